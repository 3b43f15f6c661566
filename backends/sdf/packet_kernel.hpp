#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/geometry/triangle_tree_nodes.hpp"

namespace musclebench {

/// What the SIMD part of a PacketSearch works on; lengths are in the tree's own frame and unit.
struct PacketTask {
  static constexpr std::size_t most_points = 8;
  static constexpr std::size_t capacity = 32;

  struct Point {
    std::array<float, 3> at;
    std::array<float, 3> from_middle;
    float limit;            ///< no float distance of the closest triangle is larger
    std::size_t count = 0;  ///< triangles whose distance was within the limit when they were found
    std::array<float, capacity> squared;
    std::array<std::int32_t, capacity> triangle;
  };

  const TreeNode* nodes = nullptr;
  const TreeLeaf* leaves = nullptr;
  std::array<float, 3> middle{};
  float reach = 0;         ///< of the points from the middle
  float longest_side = 0;  ///< of a triangle
  float slack = 0;         ///< as in TreeSearch
  int first_leaf = 0;      ///< looked at before all others
  std::size_t count = 0;
  std::array<Point, most_points> points;

  /// Called when a point's list is full: empties it and may lower its limit.
  void (*decide)(PacketTask& task, std::size_t point) = nullptr;
};

/// Lists, for every point, the triangles that may be its closest.
void search_packet(PacketTask& task);

}  // namespace musclebench
