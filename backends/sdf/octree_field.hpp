#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "backends/sdf/octree_polynomial.hpp"
#include "core/geometry/triangle_mesh.hpp"

namespace musclebench {

/// A box of cubes, each the root of an octree.
struct OctreeShape {
  Vec3 lower_m = Vec3::Zero();
  double root_edge_m = 1;
  std::array<std::int32_t, 3> roots{1, 1, 1};

  [[nodiscard]] std::size_t root_count() const {
    return static_cast<std::size_t>(roots[0]) * static_cast<std::size_t>(roots[1]) * static_cast<std::size_t>(roots[2]);
  }
  [[nodiscard]] std::size_t root(std::size_t i, std::size_t j, std::size_t k) const {
    return (k * static_cast<std::size_t>(roots[1]) + j) * static_cast<std::size_t>(roots[0]) + i;
  }
  [[nodiscard]] Vec3 upper_m() const { return lower_m + root_edge_m * Vec3(roots[0], roots[1], roots[2]); }
};

/// What was asked of an adaptive field and what was reached. Lengths in metres.
struct OctreeQuality {
  double wanted_m = 0;  ///< for 99 of 100 places within `near_m` of the surface
  double near_m = 0;
  double p99_m = 0;  ///< at random places up to `near_m` to both sides of the surface
  double largest_m = 0;
  double mean_m = 0;
  std::int64_t samples = 0;
  /// Where the field may have the wrong sign, it is nowhere farther than this from the exact distance: proven from
  /// samples and slopes, so mostly far above the largest error there is.
  double bound_m = 0;
  /// Outside the bone and farther than this from its surface the field is not negative: proven, too.
  double negative_reach_m = 0;
  /// At the corners of a leaf with a polynomial, the middles of its edges and faces and its own middle the field, where
  /// it is positive, is above the exact distance by no more than this.
  double excess_m = 0;
  double finest_edge_m = 0;
};

/// A signed distance field on an octree: in every leaf a polynomial of degree 2 or 3, fitted to the exact distance and
/// its gradient (after Koschier et al. 2017, Hierarchical hp-adaptive signed distance fields, with least squares in
/// place of projection). Negative inside, in metres. Made by `build_octree`.
///
/// Leaves are fitted each for itself: across a common face the field jumps by about the error of the two, at 99 of 100
/// places by no more than the wanted error. Leaves outside that keep a distance of `near_m` from the surface hold no
/// polynomial; the field is a lower bound of the distance there. Queries are const and safe from several threads.
class OctreeField {
 public:
  /// An entry of the tree: what it is in the two upper bits, where to go on in the others.
  enum class Kind : std::uint32_t {
    split = 0,    ///< the first of its eight children, x changing fastest; they follow each other
    outside = 1,  ///< outside for certain; a coefficient: lower bound of the distance at its centre
    quadratic = 2,
    cubic = 3  ///< the first coefficient
  };
  static constexpr std::uint32_t place_bits = 30;
  static constexpr std::uint32_t most_places = std::uint32_t{1} << place_bits;
  static constexpr std::uint32_t entry(Kind kind, std::size_t place) {
    return static_cast<std::uint32_t>(kind) << place_bits | static_cast<std::uint32_t>(place);
  }
  static constexpr Kind kind_of(std::uint32_t entry) { return static_cast<Kind>(entry >> place_bits); }
  static constexpr std::size_t place_of(std::uint32_t entry) { return entry & (most_places - 1); }

  struct Sample {
    double value_m = 0;
    Vec3 gradient = Vec3::Zero();  ///< of the polynomial: about, but not exactly, of unit length
  };

  /// `entries` starts with the roots.
  OctreeField(const OctreeShape& shape, const OctreeQuality& quality, std::vector<std::uint32_t> entries,
              std::vector<float> coefficients);

  [[nodiscard]] const OctreeShape& shape() const { return m_shape; }
  [[nodiscard]] const OctreeQuality& quality() const { return m_quality; }
  [[nodiscard]] std::size_t bytes() const {
    return m_entries.size() * sizeof(std::uint32_t) + m_coefficients.size() * sizeof(float);
  }
  /// Leaves with a polynomial.
  [[nodiscard]] std::size_t leaf_count() const { return m_leaves; }
  /// The smallest edge of a leaf.
  [[nodiscard]] double step_m() const { return m_quality.finest_edge_m; }

  /// Nothing outside the domain. Where no polynomial is, the lower bound of the distance and its gradient.
  [[nodiscard]] std::optional<double> value(const Vec3& point) const;
  [[nodiscard]] std::optional<Sample> sample(const Vec3& point) const;

  /// `sample` where it is negative, else nothing: cheap where the field holds no polynomial.
  [[nodiscard]] std::optional<Sample> sample_inside(const Vec3& point) const;

  /// The radius of a ball about `point` in which the field is nowhere negative, in metres; 0 when nothing is known.
  [[nodiscard]] double clearance_m(const Vec3& point) const;

  [[nodiscard]] const std::vector<std::uint32_t>& entries() const { return m_entries; }
  [[nodiscard]] const std::vector<float>& coefficients() const { return m_coefficients; }

 private:
  struct Leaf {
    Kind kind;
    const float* coefficients;
    Vec3 at;  ///< in [-1, 1]^3
    double half_edge_m;
  };
  [[nodiscard]] std::optional<Leaf> find(const Vec3& point) const;
  [[nodiscard]] static Sample sample(const Leaf& leaf);
  [[nodiscard]] double distance_at_least_m(const Vec3& point, const Leaf& leaf) const;

  OctreeShape m_shape;
  OctreeQuality m_quality;
  Vec3 m_roots;
  double m_roots_per_m;
  std::vector<std::uint32_t> m_entries;
  std::vector<float> m_coefficients;
  std::size_t m_leaves = 0;
};

}  // namespace musclebench
