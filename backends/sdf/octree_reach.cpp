#include "backends/sdf/octree_reach.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace musclebench {

namespace {

/// Parts of a leaf whose corners are no farther from their middle than this, over the least reach, are not divided.
constexpr double finest_part = 0.25;

const double half_diagonal = std::sqrt(3.0) * (1 + 1e-9);

/// Divides a leaf until its parts are known to be positive, or near enough to the surface.
class ReachSearch {
 public:
  ReachSearch(const SignedSurface& surface, const OctreeCell& cell, const PolynomialFit& fit, std::size_t terms,
              double least_m)
      : m_surface(surface),
        m_cell(cell),
        m_fit(fit),
        m_terms(terms),
        m_steepest(fit.steepest(cell.half_edge_m)),
        m_rounding_m(1e-9 * cell.half_edge_m),
        m_finest_m(finest_part * least_m),
        m_reach_m(least_m) {
    const CellSamples& samples = cell.leaf->samples;
    for (; m_known < known_samples(samples); ++m_known) {
      m_deepest[m_known] = {samples[m_known].value_m, sample_place(m_known)};
    }
    std::sort(m_deepest.begin(), m_deepest.begin() + static_cast<std::ptrdiff_t>(m_known),
              [](const Known& a, const Known& b) { return a.value_m < b.value_m; });
  }

  double reach_m() {
    visit(Vec3::Zero(), 1);
    return m_reach_m;
  }

 private:
  struct Known {
    double value_m;
    Vec3 at;
  };

  /// A cube, in units of the leaf.
  void visit(const Vec3& at, double half) {
    const double radius_m = half_diagonal * half * m_cell.half_edge_m;
    if (m_fit.value(at, m_terms) > m_steepest * radius_m + m_rounding_m) {
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

  /// Not less than the exact distance of a place; any number up to `enough_m` is as good as another.
  [[nodiscard]] double distance_at_most_m(const Vec3& at, double enough_m) const {
    double result_m = std::numeric_limits<double>::infinity();
    for (std::size_t n = 0; n < m_known && m_deepest[n].value_m < result_m; ++n) {
      result_m = std::min(result_m, m_deepest[n].value_m + m_cell.half_edge_m * (at - m_deepest[n].at).norm());
    }
    // Deep inside the samples say enough.
    if (result_m > enough_m && enough_m > 0) {
      result_m = m_surface.locate(m_cell.centre_m + m_cell.half_edge_m * at).signed_distance_m();
    }
    return result_m + m_rounding_m;
  }

  const SignedSurface& m_surface;
  const OctreeCell& m_cell;
  const PolynomialFit& m_fit;
  std::size_t m_terms;
  double m_steepest;
  double m_rounding_m;
  double m_finest_m;
  double m_reach_m;
  std::array<Known, cell_samples> m_deepest;  ///< what is known, by distance
  std::size_t m_known = 0;
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
