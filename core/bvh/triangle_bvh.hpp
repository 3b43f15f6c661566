#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/distance/triangle_distance.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

struct BvhClusters;
struct BvhLeaf;
struct BvhNode;
struct CandidateLeaves;

struct ClosestPoint {
  Vec3 point = Vec3::Zero();
  double distance_m = 0;
  int triangle = -1;
  Feature feature = Feature::face;
};

/// Result of a search among candidate triangles.
struct ClosestCandidate {
  ClosestPoint closest;
  /// No triangle outside the list can be as close: `closest` is what a full search would find.
  bool certain = false;
  /// If positive, the other members are not set, and no triangle at all is closer than this.
  double clearance_m = 0;
};

/// A lower bound of a point's distance, and a triangle near it.
struct Clearance {
  double distance_m = 0;
  int triangle = -1;
};

/// Where a straight path passes through the surface.
struct PathCrossing {
  double share = 0;  ///< of the path, from 0 to 1
  int triangle = -1;
  bool entering = false;  ///< against the triangle's normal by its winding
};

/// An 8-wide bounding volume hierarchy (BVH) over the triangles of a mesh, for closest points and winding numbers.
/// Boxes and triangles are tested in single precision, eight at a time, only to prune: the tests allow for their
/// rounding error (reports/performance/bvh_error_bounds.md), and `closest_on_triangle` decides in double precision. So
/// every answer is that of brute force to the bit, on any CPU: of all triangles the one with the smallest squared
/// distance by `closest_on_triangle`, of several the one with the smallest index. Points are in the mesh's frame, in
/// metres. The mesh need not outlive the tree. Queries are const and safe from several threads.
class TriangleBvh {
 public:
  explicit TriangleBvh(const TriangleMesh& mesh);
  TriangleBvh(TriangleBvh&& other) noexcept;
  TriangleBvh& operator=(TriangleBvh&& other) noexcept;
  TriangleBvh(const TriangleBvh&) = delete;
  TriangleBvh& operator=(const TriangleBvh&) = delete;
  ~TriangleBvh();

  /// The closest point; nothing where the surface is farther than `max_distance_m`, for a point that is not finite and
  /// for a mesh without triangles.
  [[nodiscard]] std::optional<ClosestPoint> closest_point(
      const Vec3& point, double max_distance_m = std::numeric_limits<double>::infinity()) const;

  /// The answer of `closest_point` to the bit, found faster the closer `triangle` is, such as the closest one of a
  /// neighbouring query. `triangle` may be any triangle of the mesh.
  [[nodiscard]] ClosestPoint closest_point_from(const Vec3& point, int triangle) const;

  /// A lower bound of the distance to the closest triangle: at least 0.9 of it, less the slack of single precision.
  /// Much cheaper than `closest_point_from`. `triangle` may be any triangle of the mesh; one near the point is fastest.
  /// 0 for a point for which `list_candidate_leaves` lists nothing.
  [[nodiscard]] Clearance clearance_from(const Vec3& point, int triangle) const;

  /// The closest point of one triangle.
  [[nodiscard]] ClosestOnTriangle closest_on(const Vec3& point, int triangle) const {
    const auto& [a, b, c] = m_corners[static_cast<std::size_t>(triangle)];
    return closest_on_triangle(point, a, b, c);
  }

  /// Lists the leaves within `radius_m` of `point`, or the nearest of them. The list is empty for a point that is not
  /// finite or more than 1e12 times the mesh's size away.
  void list_candidate_leaves(const Vec3& point, double radius_m, CandidateLeaves& list) const;

  /// Searches the leaves of a list that is not empty. If they are enough to tell, the result is `certain` and that of
  /// `closest_point` to the bit; else its triangle is one near the point, or -1. If all triangles are certainly farther
  /// away than `enough_m`, the result is only that lower bound. The first part prunes and prefetches the corners of the
  /// candidates, the second decides in double precision, so that a caller can overlap the cache misses of several
  /// points.
  struct Search;
  void begin_candidate_search(const Vec3& point, const CandidateLeaves& list, Search& search) const;
  [[nodiscard]] ClosestCandidate finish_candidate_search(Search& search, const CandidateLeaves& list,
                                                         double enough_m) const;
  /// Prefetches the leaves that `begin_candidate_search` reads first: few points move so far that it reads more.
  void prefetch_leaves(const CandidateLeaves& list) const;

  /// Generalised winding number (Jacobson et al. 2013) with dipoles for distant clusters (Barill et al. 2018): about 1
  /// inside a closed surface wound outwards, 0 outside; a point is inside where it exceeds 0.5. A result within 0.25 of
  /// 0.5 is computed again with finer clusters, in the end exactly.
  [[nodiscard]] double winding_number(const Vec3& point) const;

  /// Finds where the path from `from` to `to` passes through triangles, in its order, into `crossings`, which is
  /// overwritten. A path through an edge or a corner of a closed surface passes through one triangle there, not through
  /// none or two. Nothing for a path that is not finite.
  void find_crossings(const Vec3& from, const Vec3& to, std::vector<PathCrossing>& crossings) const;

  /// Calls `visit` with the indices of each pair of triangles whose AABBs overlap or nearly do, once a pair.
  void for_each_close_pair(const std::function<void(int, int)>& visit) const;

  /// Normal of a triangle by its winding, of a length of twice its area in m2.
  [[nodiscard]] Vec3 area_normal(int triangle) const {
    const auto& [a, b, c] = m_corners[static_cast<std::size_t>(triangle)];
    return (b - a).cross(c - a);
  }

  /// Whether the triangle is so narrow that the distance by `closest_on_triangle` may exceed the true one by more than
  /// the slack of a search. The 1-Lipschitz bounds that lists rely on do not hold for it.
  [[nodiscard]] bool is_sliver(int triangle) const;

  [[nodiscard]] std::size_t triangle_count() const { return m_corners.size(); }
  /// By triangle, for `closest_on_triangles`.
  [[nodiscard]] const std::array<Vec3, 3>* corners() const { return m_corners.data(); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  friend class TriangleBvhBuilder;
  friend class BatchedClosestPoint;
  friend class MovingSurfaceTree;

  /// BvhSearch::slack for points with coordinates up to `reach` in the tree's frame and up to `coordinate` in the
  /// mesh's, both in the tree's unit of length.
  [[nodiscard]] float slack_for(double reach, double coordinate) const;
  /// A smaller slack for triangles at distance d: near_slack_for + slack_growth * d.
  [[nodiscard]] float near_slack_for(double reach, double coordinate) const;
  static constexpr float slack_growth = 27 * 0x1p-24F;
  void prepare(const Vec3& point, Search& search) const;
  [[nodiscard]] Search search_for(const Vec3& point) const;
  /// Whether single precision can prune: the point is finite and within bvh_horizon.
  [[nodiscard]] bool within_horizon(const Vec3& point) const;
  void search_all(Search& search) const;
  void prefetch_ancestors(const CandidateLeaves& list) const;
  /// Clusters farther away than `opening` times their radius count as dipoles.
  [[nodiscard]] double winding_number(const Vec3& point, double opening) const;
  [[nodiscard]] double leaf_winding(const BvhLeaf& leaf, const Vec3& point) const;

  std::vector<BvhNode> m_nodes;
  std::vector<BvhLeaf> m_leaves;
  std::vector<BvhClusters> m_clusters;         ///< by node
  std::vector<std::array<Vec3, 3>> m_corners;  ///< by triangle
  std::vector<int> m_leaf_of;                  ///< by triangle

  // The tree's frame is scale * (position - centre).
  Vec3 m_centre_m = Vec3::Zero();
  double m_scale = 1;         ///< a power of two, so that it rounds nothing
  double m_longest_side = 0;  ///< of all triangles, in the tree's unit
  double m_reach = 0;         ///< largest coordinate of a vertex in the mesh's frame, in the tree's unit
};

}  // namespace musclebench
