#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "core/bvh/batch/candidate_pairs.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/bvh/triangle_bvh_search.hpp"
#include "core/distance/closest_on_triangles.hpp"

namespace musclebench {

/// A few query points that lie close together, and their closest points.
struct PointBatch {
  static constexpr std::size_t capacity = 8;

  std::size_t count = 0;
  std::array<Vec3, capacity> point;
  std::array<ClosestPoint, capacity> closest;

  void add(const Vec3& position) { point[count++] = position; }
};

/// Finds the closest points of many query points that lie close together in one traversal of a TriangleBvh: linear
/// bounds of the squared distance hold for all points of a box, and are the tighter the farther the surface is
/// (reports/performance/batched_closest_point.md). Culled in three levels: nodes once a query box, leaves once a
/// bundle, triangles once per two batches of points.
///
/// Single precision only prunes; `closest_on_triangle` decides. So the answers are those of TriangleBvh::closest_point,
/// to the bit. One thread at a time: the lists are reused by the next call.
class BatchedClosestPoint {
 public:
  /// Batches that follow each other and should lie close together; some may be empty.
  static constexpr std::size_t bundle = 8;

  explicit BatchedClosestPoint(const TriangleBvh& bvh);

  /// All query points lie in `box`, within 1e12 times the mesh's size, until the next call. `triangle` may be any; the
  /// search is the faster the nearer it is to the middle of the box.
  void begin(const Eigen::AlignedBox3d& box, int triangle);

  void closest_points(std::span<PointBatch> batches);

 private:
  /// A triangle that is no sliver, near the given one where there is one, as leaf number * bvh_width + lane; negative
  /// where the mesh has none.
  [[nodiscard]] std::int32_t bounding_triangle(int triangle) const;
  void search_bundle(std::span<PointBatch> batches);
  /// Adds to the points of the query batch; `number`: index of the added ones in their bundle.
  void add_points(const PointBatch& added, std::size_t number);
  void search_points(const QueryBox& box);
  void decide(std::span<PointBatch> batches);
  [[nodiscard]] QueryBox query_box(const Eigen::AlignedBox3d& box) const;
  [[nodiscard]] std::array<float, 3> to_tree_frame(const Vec3& point) const;
  [[nodiscard]] BvhView view_from(const Eigen::AlignedBox3d& box) const;

  const TriangleBvh* m_bvh;
  std::int32_t m_any_triangle = -1;  ///< that is no sliver, as `bounding_triangle` has it
  Eigen::AlignedBox3d m_bounds;      ///< of the query points
  BvhView m_view{};
  QueryBox m_box;  ///< the same as `m_bounds`
  BoundList m_nodes;
  BoundList m_near;
  BoundList m_leaves;
  QueryBatch m_batch;
  CandidateTriangles m_candidates;
  std::vector<ClosestOnTriangles> m_found;
};

}  // namespace musclebench
