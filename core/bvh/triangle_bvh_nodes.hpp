#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace musclebench {

/// Children of a node and triangles of a leaf: what a search looks at side by side, whatever the width of the CPU's
/// vectors.
inline constexpr std::size_t bvh_width = 8;

using BvhLanes = std::array<float, bvh_width>;

/// Where unused places are: farther than any point that the tree is searched for, and its square is still a float.
inline constexpr float bvh_far_away = 1e18F;
/// Points beyond this distance, in the tree's own unit, are not searched for in floats.
inline constexpr float bvh_horizon = 1e12F;

/// Up to `bvh_width` children in the tree's own frame (about the middle of the mesh, which fits in -1 .. 1), each
/// bounded by a box along the axes and by one along its mean normal: a nearly flat patch fills little of the first, and
/// most of what a search must look into is such a box that the sphere of the best distance cuts. All bounds are rounded
/// outwards.
struct alignas(64) BvhNode {
  std::array<BvhLanes, 3> lower;
  std::array<BvhLanes, 3> upper;
  // Of the turned box. The third axis is `normal` times `tangent`; all are a little shorter than 1 and orthogonal, so
  // that lengths along them never exceed a distance.
  std::array<BvhLanes, 3> normal;
  std::array<BvhLanes, 3> tangent;
  BvhLanes slab_lower;  ///< along the normal
  BvhLanes slab_upper;
  std::array<BvhLanes, 2> side_lower;  ///< along the tangent and the third axis
  std::array<BvhLanes, 2> side_upper;
  std::array<std::int32_t, bvh_width> child;  ///< index of a node, or ~index of a leaf
};

/// Up to `bvh_width` triangles in the tree's own frame, each in a frame of its own: `origin` is the foot of the height
/// on the longest side, `along` the unit vector of that side, which reaches from -before to after, `up` the unit vector
/// to the opposite corner at `height`. The frame is orthonormal for a sliver and even for a triangle without area, so
/// that rounding moves a distance by no more than it moves a corner (the error bound is in triangle_bvh_search.cpp).
struct alignas(64) BvhLeaf {
  std::array<BvhLanes, 3> origin;
  std::array<BvhLanes, 3> along;
  std::array<BvhLanes, 3> up;
  BvhLanes before;
  BvhLanes after;
  BvhLanes height;
  std::array<std::int32_t, bvh_width> triangle;
  std::int32_t count;
  /// One bit a triangle that is such a sliver that `closest_on_triangle` may answer it too far away: its distance here
  /// is no upper bound of that answer.
  std::uint32_t slivers;
  std::array<std::int32_t, 6> above;  ///< the nodes that it is below, the lowest first; negative behind the root

  /// Of a triangle that it holds.
  [[nodiscard]] std::size_t place_of(std::int32_t which) const {
    return static_cast<std::size_t>(std::find(triangle.begin(), triangle.end(), which) - triangle.begin());
  }
};

/// The leaves about a place: enough to find the closest triangle for points near that place without a search. A leaf at
/// distance d from the place is at least d less the way from there to the point. (What molecular dynamics calls a
/// Verlet list.) Small, because there is one for each node that is near a bone, and each step brings all of them from
/// memory. Lengths are in the tree's own frame and unit.
struct CandidateLeaves {
  static constexpr std::size_t capacity = 8;
  static constexpr float steps = 255;

  std::array<float, 3> place{};
  float complete = 0;                             ///< whatever is not listed is at least this far from the place
  std::array<std::int32_t, capacity> leaf{-1};    ///< negative behind the last
  std::array<std::uint8_t, capacity> distance{};  ///< ascending, in steps of `complete`; not more than the true one

  /// Nothing is known.
  [[nodiscard]] bool empty() const { return leaf[0] < 0; }
  void clear() { leaf[0] = -1; }
};
static_assert(sizeof(CandidateLeaves) == 56, "what CachedPointQuery keeps beside it is in the same cache line");

}  // namespace musclebench
