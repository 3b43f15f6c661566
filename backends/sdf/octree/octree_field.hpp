#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "backends/sdf/grid/cell_map.hpp"
#include "backends/sdf/grid/field_block.hpp"
#include "backends/sdf/grid/grid_shape.hpp"
#include "backends/sdf/octree/octree_kernel.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A box of cubes, each the root of an octree.
struct OctreeShape {
  Vec3 lower_m = Vec3::Zero();
  double root_edge_m = 1;
  std::array<std::int32_t, 3> roots{1, 1, 1};

  [[nodiscard]] GridIndex root_grid() const {
    return {
        {static_cast<std::size_t>(roots[0]), static_cast<std::size_t>(roots[1]), static_cast<std::size_t>(roots[2])}};
  }
  [[nodiscard]] std::size_t root_count() const { return root_grid().size(); }
  [[nodiscard]] Vec3 upper_m() const { return lower_m + root_edge_m * Vec3(roots[0], roots[1], roots[2]); }
  /// With a cell for each root.
  [[nodiscard]] GridShape grid() const { return {lower_m, Vec3::Constant(root_edge_m), roots}; }
};

/// The error that an adaptive field was built for, and what was reached. Lengths in metres.
struct OctreeQuality {
  double wanted_m = 0;  ///< for 99 of 100 points within `near_m` of the surface
  double near_m = 0;
  double p99_m = 0;  ///< at random points up to `near_m` to both sides of the surface
  double largest_m = 0;
  double mean_m = 0;
  std::int64_t samples = 0;
  /// Proven bound of the error where the field may have the wrong sign, from samples and Lipschitz bounds, so mostly
  /// far above the largest error there is.
  double bound_m = 0;
  /// Outside the bone and farther than this from its surface the field is not negative: proven, too.
  double sign_error_distance_m = 0;
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
/// points by no more than the wanted error. Leaves outside that keep a distance of `near_m` from the surface hold no
/// polynomial; the field is a lower bound of the distance there. Queries are const and safe from several threads.
class OctreeField {
 public:
  struct Sample {
    double value_m = 0;
    Vec3 gradient = Vec3::Zero();  ///< of the polynomial: about, but not exactly, of unit length
  };

  /// `entries` starts with the roots; `coefficients` ends with `cubic_terms` numbers that no leaf has, so that any leaf
  /// may be read as if it were cubic.
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

  /// The radius of a sphere around `point` in which the field is nowhere negative, in metres; 0 when nothing is known.
  [[nodiscard]] double clearance_m(const Vec3& point) const;

  /// Of many points: appends to `block` those of `nodes` (ascending indices into `positions`) from `first` on that are
  /// in the domain, mapped by `map` (of `shape().grid()`), and evaluates them when the block is full or all nodes were
  /// visited. Returns the index in `nodes` to go on at. `query` is the index in `nodes`. A NaN position is outside.
  std::size_t sample(const CellMap& map, std::span<const Vec3> positions, std::span<const int> nodes, std::size_t first,
                     FieldBlock& block, LeafBlock& leaves) const;
  /// `clearance_m` of the points of such a block.
  void clear(const FieldBlock& block, const LeafBlock& leaves, FieldBlock::Lanes<double>& clearance_m) const;

  [[nodiscard]] const std::vector<std::uint32_t>& entries() const { return m_entries; }
  [[nodiscard]] const std::vector<float>& coefficients() const { return m_coefficients; }

 private:
  [[nodiscard]] OctreeView view() const;
  /// Of one point; whether it is in the domain.
  bool sample(const Vec3& point, FieldBlock& block, LeafBlock& leaves) const;

  OctreeShape m_shape;
  OctreeQuality m_quality;
  std::vector<std::uint32_t> m_entries;
  std::vector<float> m_coefficients;
  std::size_t m_leaves = 0;
};

}  // namespace musclebench
