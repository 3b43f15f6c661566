#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/bvh/triangle_bvh_nodes.hpp"

namespace musclebench {

// Lists of what may be near a box of query points, each entry with a linear lower bound of its squared distance.
// Lengths are in the BVH's own frame and unit. reports/performance/batched_closest_point.md derives the bounds.

/// Beyond every limit.
inline constexpr float far_away = 3e38F;

/// A BVH as the kernels read it, with the rounding errors for the farthest of the query points.
struct BvhView {
  const BvhNode* nodes = nullptr;
  const BvhLeaf* leaves = nullptr;
  float longest_side = 0;  ///< of a triangle
  float slack = 0;         ///< as in BvhSearch
  float near_slack =
      0;  ///< a single-precision distance d to a triangle is off by at most near_slack + slack_growth * d
  float slack_growth = 0;
};

/// A box around query points, and an upper bound of their distances: the squared distance to the closest triangle, in
/// single precision, is at most most + slope * r + r^2, where r is the query point less the middle of the box.
struct QueryBox {
  std::array<float, 3> middle{};
  std::array<float, 3> half{};
  std::array<float, 3> slope{};
  float most = 0.25F * bvh_far_away * bvh_far_away;
};

/// Nodes or leaves, each with a lower bound of its squared distance, value + slope * r + r^2, where r is the query
/// point less the middle of the box that they were listed for. Padded at the end with entries that are far away.
struct BoundList {
  static constexpr std::size_t padding = 16;

  std::size_t count = 0;
  std::vector<float> value;
  std::array<std::vector<float>, 3> slope;
  std::vector<std::int32_t> child;  ///< a node's number, or for a leaf its parent's number * bvh_width + its lane there

  void make_room(std::size_t more);
};

/// Takes the upper bound by one triangle (leaf number * bvh_width + lane), which is no sliver, where it is lower in the
/// middle of the box.
void bound_by_triangle(const BvhView& bvh, std::int32_t triangle, QueryBox& box);

/// Lists the nodes that may hold the closest triangle of a point of the box.
void list_nodes(const BvhView& bvh, const QueryBox& box, BoundList& nodes);

/// Lists the leaves that may hold the closest triangle of a point of `box`: children of `nodes`, which were listed for
/// the larger box `outer`. Lowers the upper bound of `box` first. `near` is scratch memory.
void list_leaves(const BvhView& bvh, const BoundList& nodes, const QueryBox& outer, QueryBox& box, BoundList& near,
                 BoundList& leaves);

}  // namespace musclebench
