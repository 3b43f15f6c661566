#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/bvh/triangle_bvh_nodes.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What the SIMD part of a closest-point search works on. All lengths are in the tree's own frame and unit. It prunes
/// only: it leaves every triangle that may be the closest one, and the caller decides between them in double.
struct BvhSearch {
  static constexpr std::size_t capacity = 64;

  const BvhNode* nodes = nullptr;
  const BvhLeaf* leaves = nullptr;
  const std::array<Vec3, 3>* corners = nullptr;  ///< of each triangle, which are fetched early for the caller
  std::array<float, 3> point{};
  /// No float distance here (to a box, a slab or a triangle) is farther from the truth, the caller's own answers in
  /// double included.
  float slack = 0;
  /// Square of a distance that nothing closest exceeds in the floats here.
  float limit = 0;
  float least = bvh_far_away * bvh_far_away;  ///< square of the smallest distance within the limit that was met
  int first_leaf = -1;                        ///< looked at before all others; -1: none

  /// Triangles whose distance was within the limit when they were found.
  std::size_t count = 0;
  std::array<float, capacity> squared;
  std::array<std::int32_t, capacity> triangle;

  /// Called when the list is full: empties it and may lower the limit. Called for slivers, too.
  void (*decide)(BvhSearch& search) = nullptr;
};

/// Lists what may be the closest triangle.
void search_closest(BvhSearch& search);

/// Leaves with the squares of their float distances, ascending.
struct NearestLeaves {
  std::size_t count = 0;
  std::array<std::int32_t, CandidateLeaves::capacity> leaf;
  std::array<float, CandidateLeaves::capacity> squared;
  float others = 0;  ///< what all others keep
};

/// The leaves that hold a triangle within `search.limit`, the nearest of them where there are too many.
NearestLeaves search_leaves(const BvhSearch& search);

/// The square of a float distance that nothing is closer than, and the closest triangle that was met.
struct DistanceBound {
  float squared = 0;
  std::int32_t triangle = 0;
};

/// Starting from `first_leaf`, some leaf near the point. The bound is at least `share` (squared) of the smallest one.
DistanceBound search_bound(const BvhSearch& search, float share);

/// Looks at the listed leaves only, as far as they may hold something within the limit for a point that is `moved` (own
/// unit) away from the list's place.
void search_listed(BvhSearch& search, const CandidateLeaves& list, float moved);

}  // namespace musclebench
