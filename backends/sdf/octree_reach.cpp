#include "backends/sdf/octree_reach.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace musclebench {

namespace {

/// Parts of a leaf whose corners are no farther from their middle than this, over the least reach, are not divided.
constexpr double finest_part = 0.25;

std::array<Vec3, cell_samples> sample_places() {
  std::array<Vec3, cell_samples> places;
  for (std::size_t s = 0; s < cell_samples; ++s) {
    places[s] = sample_place(s);
  }
  return places;
}

/// Divides a leaf until its parts are known to be positive, or near enough to the surface.
class ReachSearch {
 public:
  ReachSearch(const SignedSurface& surface, const OctreeCell& cell, const PolynomialFit& fit, std::size_t terms,
              double least_m)
      : m_surface(surface),
        m_cell(cell),
        m_fit(fit),
        m_terms(terms),
        m_known(known_samples(cell.leaf->samples)),
        m_rounding_m(1e-9 * cell.half_edge_m),
        m_finest_m(finest_part * least_m),
        m_reach_m(least_m) {
    for (std::size_t term = 0; term < terms; ++term) {
      const auto& [x, y, z] = polynomial_powers[term];
      const int degree = x + y + z;
      m_curved_m += 0.5 * degree * (degree - 1) * std::abs(static_cast<double>(fit.coefficients[term]));
    }
  }

  double reach_m() {
    visit(Vec3::Zero(), 1);
    return m_reach_m;
  }

 private:
  /// A cube, in units of the leaf.
  void visit(const Vec3& at, double half) {
    const double radius_m = half * m_cell.reach_m();
    if (value_at_least_m(at, half) > m_rounding_m) {
      return;
    }
    const double farthest_m = distance_at_most_m(at, m_reach_m - radius_m) + radius_m;
    if (farthest_m <= m_reach_m) {
      return;
    }
    if (radius_m <= m_finest_m) {
      m_reach_m = farthest_m;
      return;
    }
    for (std::size_t octant = 0; octant < 8; ++octant) {
      visit(at + half * sample_place(lattice_samples + octant), 0.5 * half);
    }
  }

  /// Of the polynomial in such a cube: by its slope in the middle and by how much that changes.
  [[nodiscard]] double value_at_least_m(const Vec3& at, double half) const {
    Vec3 slope;
    const double value_m = m_terms == cubic_terms ? evaluate_polynomial<true>(m_fit.coefficients.data(), at, slope)
                                                  : evaluate_polynomial<false>(m_fit.coefficients.data(), at, slope);
    return value_m - half * (slope.cwiseAbs().sum() + half * m_curved_m);
  }

  /// Not less than the exact distance of a place; any number up to `enough_m` is as good as another.
  [[nodiscard]] double distance_at_most_m(const Vec3& at, double enough_m) const {
    static const std::array<Vec3, cell_samples> places = sample_places();
    const CellSamples& samples = m_cell.leaf->samples;
    double result_m = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < m_known && result_m > enough_m; ++s) {
      result_m = std::min(result_m, samples[s].value_m + m_cell.half_edge_m * (at - places[s]).norm());
    }
    // A part that is larger than the reach is divided, whatever is known of it.
    if (result_m > enough_m && enough_m > 0) {
      result_m = m_surface.locate(m_cell.centre_m + m_cell.half_edge_m * at).signed_distance_m();
    }
    return result_m + m_rounding_m;
  }

  const SignedSurface& m_surface;
  const OctreeCell& m_cell;
  const PolynomialFit& m_fit;
  std::size_t m_terms;
  std::size_t m_known;
  double m_rounding_m;
  double m_finest_m;
  double m_reach_m;
  double m_curved_m = 0;  ///< second derivatives along a cube's half diagonals at most, halved
};

}  // namespace

double negative_reach_m(const SignedSurface& surface, const OctreeCell& cell, const PolynomialFit& fit,
                        std::size_t terms, double least_m) {
  if (cell.inside() || fit.smallest() > 1e-9 * cell.half_edge_m) {
    return least_m;
  }
  return ReachSearch(surface, cell, fit, terms, least_m).reach_m();
}

}  // namespace musclebench
