#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/bvh/batch/packet_lists.hpp"

namespace musclebench {

/// Points that are looked for together, and the leaves that were looked into for them.
struct PacketPoints {
  static constexpr std::size_t capacity = 16;
  using PointLanes = std::array<float, capacity>;

  std::size_t count = 0;
  std::size_t first_count = 0;  ///< of those, but not 0: a part of them that lies closer together than all do
  alignas(64) std::array<PointLanes, 3> at;   ///< places beyond the count repeat others
  std::array<std::int32_t, capacity> number;  ///< of each point, for CandidatePairs

  std::vector<std::int32_t> near;  ///< leaves that may matter to any of the points, as in BoundList

  /// Squared distances of one point to the triangles of a leaf.
  struct alignas(32) Squared {
    BvhLanes to;
  };
  std::size_t looks = 0;
  std::vector<std::int32_t> leaf;
  std::vector<std::int32_t> point;
  std::vector<Squared> squared;

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
/// lies in it.
void list_pairs(const TreeView& tree, const BoundList& leaves, const PlaceBox& box, PacketPoints& packet,
                CandidatePairs& pairs);

}  // namespace musclebench
