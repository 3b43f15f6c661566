#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/bvh/triangle_bvh.hpp"
#include "core/bvh/triangle_bvh_nodes.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// State of the SIMD part of a closest-point search. It only prunes: every triangle that may be the closest one is left
/// as a candidate, and the caller decides between them in double precision. All lengths are in the tree's frame.
struct BvhSearch {
  static constexpr std::size_t capacity = 64;

  const BvhNode* nodes = nullptr;
  const BvhLeaf* leaves = nullptr;
  const std::array<Vec3, 3>* corners = nullptr;  ///< by triangle; prefetched for the caller's decision
  std::array<float, 3> point{};
  /// Bound of the difference between a distance computed here (to an AABB, an OBB or a triangle) and the true one, or
  /// the one that the caller computes in double precision.
  float slack = 0;
  /// Square of an upper bound of the closest triangle's distance as it is computed here.
  float limit = 0;
  float least = bvh_far_away * bvh_far_away;  ///< smallest squared distance found within the limit
  int first_leaf = -1;                        ///< searched before all others; -1: none

  /// Candidates: triangles whose squared distance was within the limit when they were found.
  std::size_t count = 0;
  std::array<float, capacity> squared;
  std::array<std::int32_t, capacity> triangle;

  /// Called when the candidates fill up, and for a leaf with slivers: empties them and may lower the limit.
  void (*decide)(BvhSearch& search) = nullptr;
};

/// Searches the whole tree for candidates.
void search_closest(BvhSearch& search);

/// Leaves by ascending squared distance.
struct NearestLeaves {
  std::size_t count = 0;
  std::array<std::int32_t, CandidateLeaves::capacity> leaf;
  std::array<float, CandidateLeaves::capacity> squared;
  float cutoff = 0;  ///< squared; no other leaf is closer
};

/// The leaves with a triangle within `search.limit`, or the nearest of them.
NearestLeaves search_leaves(const BvhSearch& search);

/// A lower bound of the squared distance, and the closest triangle that was visited.
struct DistanceBound {
  float squared = 0;
  std::int32_t triangle = 0;
};

/// Starts from `first_leaf`, which has to be given. The bound is at least `squared_fraction` of the true one.
DistanceBound search_bound(const BvhSearch& search, float squared_fraction);

/// Searches only the listed leaves for candidates. `moved`: distance of the query point from the list's point.
void search_listed(BvhSearch& search, const CandidateLeaves& list, float moved);

/// A search in single precision with the best triangle so far in double precision.
struct TriangleBvh::Search : BvhSearch {
  const TriangleBvh* tree = nullptr;
  Vec3 exact_point;
  float moved = 0;  ///< upper bound of the distance from the list's point, in the tree's unit
  ClosestOnTriangle best;
  int best_triangle = -1;

  void consider(int triangle_index);
  void decide_candidates();
  void lower_limit(double distance_m);
  [[nodiscard]] ClosestPoint answer() const;
};

}  // namespace musclebench
