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

  std::vector<std::int32_t> near;  ///< leaves that may matter to any of the points, as in BoundList

  /// Squared distances of one point to the triangles of a leaf.
  struct alignas(32) Squared {
    TreeLanes to;
  };
  std::size_t looks = 0;
  std::vector<std::int32_t> leaf;
  std::vector<std::int32_t> point;
  std::vector<Squared> squared;
  static constexpr std::size_t looks_at_once = 64;  ///< when they are gone through again
  std::vector<std::uint8_t> within;                 ///< a bit a triangle that may be the closest

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
void list_pairs(const TreeView& tree, const BoundList& leaves, const PlaceBox& box, PacketPoints& packet,
                std::int32_t first, CandidatePairs& pairs);

}  // namespace musclebench
