#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "backends/sdf/packet_lists.hpp"

namespace musclebench {

/// Points of one packet, and the leaves that were looked into for them.
struct PacketPoints {
  static constexpr std::size_t capacity = 8;

  std::size_t count = 0;
  alignas(64) std::array<TreeLanes, 3> at;

  /// Squared distances of one point to the triangles of a leaf.
  struct alignas(64) Look {
    TreeLanes squared;
    std::int32_t leaf = 0;
    std::int32_t point = 0;
  };
  std::vector<Look> look;
  std::vector<float> to_box;  ///< squared distances of each point to the boxes of all leaves

  std::size_t next = 0;  ///< looks to come
  std::vector<std::int32_t> next_leaf;
  std::vector<std::int32_t> next_point;

  void make_room(std::size_t leaves);
};

/// Points, by their number, with triangles that may be their closest.
struct CandidatePairs {
  std::size_t count = 0;
  std::vector<std::int32_t> point;
  std::vector<std::int32_t> triangle;

  void make_room(std::size_t more);
};

/// Of the leaves that were listed for `box`, adds the triangles that may be the closest of a point of the packet, which
/// lies in it; its points are numbered from `first`.
void list_pairs(const TreeView& tree, const LeafBoxes& leaves, const PlaceBox& box, PacketPoints& packet,
                std::int32_t first, CandidatePairs& pairs);

}  // namespace musclebench
