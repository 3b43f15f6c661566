#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/bvh/triangle_bvh_nodes.hpp"

namespace musclebench {

// How a PacketSearch lists what may be near a box of points; lengths are in the tree's own frame and unit.

/// Beyond every limit.
inline constexpr float packet_nowhere = 3e38F;

struct TreeView {
  const BvhNode* nodes = nullptr;
  const BvhLeaf* leaves = nullptr;
  float longest_side = 0;  ///< of a triangle
  float slack = 0;         ///< as in BvhSearch, for the farthest of the points
  float near_slack = 0;    ///< a float distance d to a triangle is off by at most near_slack + slack_growth * d
  float slack_growth = 0;
};

/// A box about places, and an upper bound of their distances: the square of that to the closest triangle in floats is
/// not more than most + slope * r + r^2, where r = place - middle.
struct PlaceBox {
  std::array<float, 3> middle{};
  std::array<float, 3> half{};
  std::array<float, 3> slope{};
  float most = 0.25F * bvh_far_away * bvh_far_away;
};

/// Nodes or leaves, each with a lower bound of its squared distance, value + slope * r + r^2, where r is from the
/// middle of the box that they were listed for. Beyond the last one stand some that are nowhere.
struct BoundList {
  static constexpr std::size_t padding = 16;

  std::size_t count = 0;
  std::vector<float> value;
  std::array<std::vector<float>, 3> slope;
  std::vector<std::int32_t> what;  ///< a node's number, or a leaf's: its parent's number * bvh_width + its place there

  void make_room(std::size_t more);
};

/// Takes the upper bound that one triangle gives, which is no sliver, where it is lower in the middle.
void bound_by_triangle(const TreeView& tree, std::int32_t triangle, PlaceBox& box);

/// Lists the nodes that may hold the closest triangle of a place of the box.
void list_nodes(const TreeView& tree, const PlaceBox& box, BoundList& nodes);

/// Lists the leaves that may hold the closest triangle of a place of `box`, and are children of nodes that were listed
/// for `outer`, in which it lies; before that lowers its bound. `near` is for the nodes among them.
void list_candidate_leaves(const TreeView& tree, const BoundList& nodes, const PlaceBox& outer, PlaceBox& box,
                           BoundList& near, BoundList& leaves);

}  // namespace musclebench
