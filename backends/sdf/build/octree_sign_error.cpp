#include "backends/sdf/build/octree_sign_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace musclebench {

namespace {

/// Parts of a leaf whose corners are no farther from their middle than this, over `least_m`, are not divided.
constexpr double finest_part = 0.25;

/// Divides a leaf until its parts are known to be positive, or near enough to the surface
/// (reports/performance/field_bounds.md).
class SignErrorSearch {
 public:
  SignErrorSearch(const SignedSurface& surface, const OctreeCell& cell, const PolynomialFit& fit, std::size_t terms,
                  double least_m)
      : m_surface(surface),
        m_cell(cell),
        m_fit(fit),
        m_terms(terms),
        m_known(known_samples(cell.leaf->samples)),
        m_rounding_m(1e-9 * cell.half_edge_m),
        m_finest_m(finest_part * least_m),
        m_sign_error_m(least_m) {
    for (std::size_t term = 0; term < terms; ++term) {
      const auto& [x, y, z] = polynomial_powers[term];
      const int degree = x + y + z;
      const auto coefficient = static_cast<double>(fit.coefficients[term]);
      const bool is_square = degree == 2 && std::max({x, y, z}) == 2;
      const double falls_m = is_square ? std::max(0.0, -coefficient) : std::abs(coefficient);
      m_curved_m += 0.5 * degree * (degree - 1) * falls_m;
    }
  }

  double sign_error_m() {
    visit(Vec3::Zero(), 1, static_cast<double>(m_fit.coefficients[0]));
    return m_sign_error_m;
  }

 private:
  /// A cube, in units of the leaf, in whose middle the polynomial has this value.
  void visit(const Vec3& at, double half, double value_m) {
    const double radius_m = half * m_cell.reach_m();
    const std::size_t sample = nearest_sample(at);
    if (by_sample_m(at, sample) + radius_m <= m_sign_error_m ||
        is_near_enough(at, radius_m, value_m, m_cell.leaf->samples[sample].triangle)) {
      return;
    }
    const PartValues parts = m_terms == cubic_terms ? part_values<true>(at, half) : part_values<false>(at, half);
    for (std::size_t octant = 0; octant < 8; ++octant) {
      if (parts.least_m[octant] <= m_rounding_m) {
        visit(at + half * sample_position(lattice_samples + octant), 0.5 * half, parts.middle_m[octant]);
      }
    }
  }

  /// Of the polynomial in the eight parts of a cube.
  struct PartValues {
    std::array<double, 8> middle_m;
    std::array<double, 8> least_m;  ///< by the slope in the middle and by how much that changes
  };

  template <bool cubic>
  [[nodiscard]] PartValues part_values(const Vec3& at, double half) const {
    PartValues parts;
    const double x = at[0], y = at[1], z = at[2];
    const double quarter = 0.5 * half;
    // One part a lane, for the compiler: a sign for each axis.
    for (std::size_t octant = 0; octant < 8; ++octant) {
      const Vec3 middle(x + (octant % 2 == 0 ? -quarter : quarter), y + (octant / 2 % 2 == 0 ? -quarter : quarter),
                        z + (octant / 4 == 0 ? -quarter : quarter));
      Vec3 slope;
      parts.middle_m[octant] = evaluate_polynomial<cubic>(m_fit.coefficients.data(), middle, slope);
      const double steepness = std::abs(slope[0]) + std::abs(slope[1]) + std::abs(slope[2]);
      parts.least_m[octant] = parts.middle_m[octant] - quarter * (steepness + quarter * m_curved_m);
    }
    return parts;
  }

  /// The nearest known sample to a point.
  [[nodiscard]] std::size_t nearest_sample(const Vec3& at) const {
    const auto side = [&](std::size_t axis) { return at[static_cast<Eigen::Index>(axis)]; };
    if (m_known == cell_samples && (at.cwiseAbs().array() - 0.5).abs().maxCoeff() <= 0.25) {
      return lattice_samples + (side(0) > 0 ? 1U : 0U) + (side(1) > 0 ? 2U : 0U) + (side(2) > 0 ? 4U : 0U);
    }
    const auto third = [&](std::size_t axis) { return static_cast<std::size_t>(side(axis) + 1.5); };
    return 9 * third(0) + 3 * third(1) + third(2);
  }

  /// An upper bound of the exact distance at a point, by a sample's.
  [[nodiscard]] double by_sample_m(const Vec3& at, std::size_t sample) const {
    return m_cell.leaf->samples[sample].value_m + m_cell.half_edge_m * (at - sample_position(sample)).norm() +
           m_rounding_m;
  }

  /// Whether no point of a part is farther from the surface than the sign error distance, which is raised to that where
  /// the part is not to be divided. The polynomial's value tells whether a query pays. The distance to a `triangle`
  /// near the part is an upper bound; where it does not suffice the exact distance mostly does, which avoids dividing.
  [[nodiscard]] bool is_near_enough(const Vec3& at, double radius_m, double value_m, int triangle) {
    const double enough_m = m_sign_error_m - radius_m - m_rounding_m;
    const bool is_finest = radius_m <= m_finest_m;
    if (!is_finest && value_m > enough_m) {
      return false;
    }
    const Vec3 point = m_cell.centre_m + m_cell.half_edge_m * at;
    if (std::abs(value_m) <= enough_m &&
        m_surface.tree().closest_on(point, triangle).squared_distance_m2 <= enough_m * enough_m) {
      return true;
    }
    const double distance_m = m_surface.locate_from(point, triangle).signed_distance_m();
    if (is_finest) {
      m_sign_error_m = std::max(m_sign_error_m, distance_m + m_rounding_m + radius_m);
    }
    return is_finest || distance_m <= enough_m;
  }

  const SignedSurface& m_surface;
  const OctreeCell& m_cell;
  const PolynomialFit& m_fit;
  std::size_t m_terms;
  std::size_t m_known;
  double m_rounding_m;
  double m_finest_m;
  double m_sign_error_m;
  /// Upper bound of how far the polynomial is below its tangent plane in a cube's middle, over the square of the cube's
  /// half edge: a square with a positive coefficient is never below.
  double m_curved_m = 0;
};

}  // namespace

double sign_error_distance_m(const SignedSurface& surface, const OctreeCell& cell, const PolynomialFit& fit,
                             std::size_t terms, double least_m) {
  const bool is_near = cell.distance_m + cell.reach_m() <= least_m;
  if (is_near || fit.smallest() > 1e-9 * cell.half_edge_m) {
    return least_m;
  }
  return SignErrorSearch(surface, cell, fit, terms, least_m).sign_error_m();
}

}  // namespace musclebench
