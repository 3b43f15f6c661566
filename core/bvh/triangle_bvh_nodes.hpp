#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Children of a node and triangles of a leaf. Fixed, so that the tree is the same on every CPU, whatever the width of
/// its vectors.
inline constexpr std::size_t bvh_width = 8;

using BvhLanes = std::array<float, bvh_width>;

/// Nodes that wait on the stack of a search: each level of the deepest tree that the builder makes leaves up to 7, and
/// a compressed store writes up to 8 entries past the last one.
inline constexpr int bvh_stack_capacity = 320;

/// Coordinate of unused slots: farther away than any point that is searched for, and its square is still a float.
inline constexpr float bvh_far_away = 1e18F;
/// Points farther away than this, in the tree's unit of length, are searched for by brute force in double precision.
inline constexpr float bvh_horizon = 1e12F;

/// The largest float that is not above `value`.
inline float bvh_round_down(double value) {
  const auto rounded = static_cast<float>(value);
  return rounded > value ? std::nextafter(rounded, -std::numeric_limits<float>::infinity()) : rounded;
}

/// The smallest float that is not below `value`.
inline float bvh_round_up(double value) { return -bvh_round_down(-value); }

/// An inner node as a structure of arrays, one child a lane, in the tree's frame (relative to the middle of the mesh,
/// scaled to fit in [-1, 1]^3). Each child is bounded by an axis-aligned box (AABB) and by an oriented one (OBB) along
/// its mean normal. A nearly flat patch fills little of its AABB, and most nodes that a search visits are such boxes,
/// cut by the sphere of the best distance; the OBB culls them. All bounds are rounded outwards.
struct alignas(64) BvhNode {
  std::array<BvhLanes, 3> lower;
  std::array<BvhLanes, 3> upper;
  // Axes of the OBB; the third one is normal x tangent. They are a little shorter than 1, so that rounded projections
  // on them never exceed a true distance.
  std::array<BvhLanes, 3> normal;
  std::array<BvhLanes, 3> tangent;
  std::array<BvhLanes, 3> obb_lower;  ///< along normal, tangent and third axis
  std::array<BvhLanes, 3> obb_upper;
  std::array<std::int32_t, bvh_width> child;  ///< index of a node, or ~index of a leaf
};

/// Up to `bvh_width` triangles in the tree's frame, one a lane, each with axes of its own: `origin` is the foot of the
/// height on the longest side, `along` the unit vector of that side, which reaches from -before to after, `up` the unit
/// vector to the opposite corner at `height`. The axes are orthonormal for a sliver and even for a triangle without
/// area, so that rounding changes a distance by no more than it moves a corner
/// (reports/performance/bvh_error_bounds.md).
struct alignas(64) BvhLeaf {
  std::array<BvhLanes, 3> origin;
  std::array<BvhLanes, 3> along;
  std::array<BvhLanes, 3> up;
  BvhLanes before;
  BvhLanes after;
  BvhLanes height;
  std::array<std::int32_t, bvh_width> triangle;
  std::int32_t count;
  /// One bit a triangle: a sliver, for which `closest_on_triangle` may round up by more than the slack of a search. The
  /// distance computed here is then no upper bound of that answer.
  std::uint32_t slivers;
  std::array<std::int32_t, 6> ancestors;  ///< nodes, from the parent up; -1 beyond the root

  /// The lane of a triangle that the leaf holds.
  [[nodiscard]] std::size_t lane_of(std::int32_t triangle_index) const {
    return static_cast<std::size_t>(std::find(triangle.begin(), triangle.end(), triangle_index) - triangle.begin());
  }
};

/// The triangles below one child of a node as a dipole (Barill et al. 2018), for winding numbers from far away.
struct BvhCluster {
  Vec3 centre = Vec3::Zero();
  Vec3 area_normal = Vec3::Zero();  ///< sum of the triangles' unit normals times their areas
  double radius = 0;                ///< of a sphere about `centre` that contains the triangles
};

/// The clusters of a node, by child.
struct BvhClusters : std::array<BvhCluster, bvh_width> {};

/// The leaves near one point, from which the closest triangle is found for points near it without going through the
/// tree: the Verlet list of molecular dynamics. By the triangle inequality a leaf at distance d from the list's point
/// is at least d - |q - point| from a point q. Small, because every mesh node near a bone has a list and each step
/// reads all of them from memory. Lengths are in the tree's frame.
struct CandidateLeaves {
  static constexpr std::size_t capacity = 8;
  static constexpr float distance_steps = 255;

  std::array<float, 3> point{};
  float cutoff = 0;                               ///< every leaf that is not listed is at least this far from the point
  std::array<std::int32_t, capacity> leaf{-1};    ///< -1 after the last one
  std::array<std::uint8_t, capacity> distance{};  ///< ascending, in units of cutoff / distance_steps, rounded down

  [[nodiscard]] bool empty() const { return leaf[0] < 0; }
  void clear() { leaf[0] = -1; }
};
static_assert(sizeof(CandidateLeaves) == 56, "with what CachedPointQuery keeps beside it, one cache line");

}  // namespace musclebench
