#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/bvh/batch/bound_list.hpp"

namespace musclebench {

/// Query points that are answered together, and their candidate pairs: a leaf and a point that it may be the closest
/// to.
struct QueryBatch {
  static constexpr std::size_t capacity = 16;
  using PointLanes = std::array<float, capacity>;

  std::size_t count = 0;
  std::size_t first_count = 0;  ///< not 0: so many points from the first on lie closer together than all do
  alignas(64) std::array<PointLanes, 3> at;   ///< lanes beyond the count repeat a point
  std::array<std::int32_t, capacity> number;  ///< of each point, for CandidateTriangles

  std::vector<std::int32_t> near;  ///< leaves that may matter to any of the points, as in BoundList

  /// Squared distances of one point to the triangles of a leaf.
  struct alignas(32) Squared {
    BvhLanes to;
  };
  std::size_t pairs = 0;
  std::vector<std::int32_t> leaf;   ///< of each pair
  std::vector<std::int32_t> point;  ///< of each pair
  std::vector<Squared> squared;     ///< of each pair

  void make_room(std::size_t leaves);
};

/// Query points, by their number, with triangles that may be their closest.
struct CandidateTriangles {
  std::size_t count = 0;
  std::vector<std::int32_t> point;
  std::vector<std::int32_t> triangle;

  void make_room(std::size_t more);
};

/// Of the leaves that were listed for `box`, adds the triangles that may be the closest of a point of the batch. All
/// its points lie in the box.
void list_candidate_triangles(const BvhView& bvh, const BoundList& leaves, const QueryBox& box, QueryBatch& batch,
                              CandidateTriangles& candidates);

}  // namespace musclebench
