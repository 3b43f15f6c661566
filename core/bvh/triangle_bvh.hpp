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

/// The point of a surface that is closest to a query point.
struct ClosestPoint {
  Vec3 point = Vec3::Zero();        ///< m, in the frame of the mesh
  double distance_m = 0;            ///< from the query point, >= 0
  int triangle = -1;                ///< that contains `point`; -1: none was found
  Feature feature = Feature::face;  ///< of the triangle, that contains `point`
};

/// The result of a search among candidate triangles.
struct ClosestCandidate {
  ClosestPoint closest;
  /// Whether `closest` is what a full search would find: no triangle outside the list can be as close.
  bool certain = false;
  /// If positive: a lower bound of the distance to the surface in metres. The other members are not set then.
  double clearance_m = 0;
};

/// A lower bound of the distance of a point from a surface.
struct Clearance {
  double distance_m = 0;
  int triangle = -1;  ///< a triangle near the point
};

/// A point where a straight path crosses the surface.
struct PathCrossing {
  double share = 0;  ///< position on the path, from 0 at its start to 1 at its end
  int triangle = -1;
  bool entering = false;  ///< the path runs against the outward normal of the triangle
};

/// An 8-wide bounding volume hierarchy (BVH) over the triangles of a mesh, for closest points and winding numbers.
///
/// A closest point has the same bits as that of brute force, on any CPU. It is on the triangle with the smallest
/// squared distance by `closest_on_triangle`. Of several such triangles it is the one with the smallest index.
/// Single-precision tests of eight boxes or triangles at a time only prune, and they allow for their rounding error
/// (reports/performance/bvh_error_bounds.md). Double precision decides.
///
/// Points are in the frame of the mesh, in metres. The mesh need not outlive the tree. Queries are const and safe from
/// several threads.
class TriangleBvh {
 public:
  /// Builds the tree. The vertices must be finite and the indices in range. The mesh may have no triangles.
  explicit TriangleBvh(const TriangleMesh& mesh);
  TriangleBvh(TriangleBvh&& other) noexcept;
  TriangleBvh& operator=(TriangleBvh&& other) noexcept;
  TriangleBvh(const TriangleBvh&) = delete;
  TriangleBvh& operator=(const TriangleBvh&) = delete;
  ~TriangleBvh();

  /// The closest point of the surface. Returns nothing if the surface is farther than `max_distance_m`, if the point is
  /// not finite, or if the mesh has no triangles.
  [[nodiscard]] std::optional<ClosestPoint> closest_point(
      const Vec3& point, double max_distance_m = std::numeric_limits<double>::infinity()) const;

  /// The same bits as `closest_point`, found faster if `triangle` is near the point. Pass the closest triangle of a
  /// neighbouring query. Any triangle of the mesh is allowed.
  [[nodiscard]] ClosestPoint closest_point_from(const Vec3& point, int triangle) const;

  /// A lower bound of the distance to the surface, much cheaper than `closest_point_from`. It is at least 0.9 of the
  /// distance, minus the rounding error of single precision. `triangle` may be any triangle of the mesh. One near the
  /// point is fastest. The bound is 0 if the point is not finite or more than 1e12 times the mesh's size away.
  [[nodiscard]] Clearance clearance_from(const Vec3& point, int triangle) const;

  /// The closest point of one triangle.
  [[nodiscard]] ClosestOnTriangle closest_on(const Vec3& point, int triangle) const {
    const auto& [a, b, c] = m_corners[static_cast<std::size_t>(triangle)];
    return closest_on_triangle(point, a, b, c);
  }

  /// Lists the leaves within `radius_m` of `point`, or the nearest of them if they do not fit. The list is empty if the
  /// point is not finite or more than 1e12 times the mesh's size away.
  void list_candidate_leaves(const Vec3& point, double radius_m, CandidateLeaves& list) const;

  /// A search among the leaves of a list that is not empty. It has two parts, so that a caller can overlap the cache
  /// misses of several points. The first part prunes, and prefetches the corners of the candidates. The second part
  /// decides in double precision.
  ///
  /// The result is `certain` if the list suffices. It then has the same bits as `closest_point`. Otherwise its triangle
  /// is one near the point, or -1. If all triangles are certainly farther than `enough_m`, the result is only a lower
  /// bound of the distance (`ClosestCandidate::clearance_m`).
  struct Search;
  void begin_candidate_search(const Vec3& point, const CandidateLeaves& list, Search& search) const;
  [[nodiscard]] ClosestCandidate finish_candidate_search(Search& search, const CandidateLeaves& list,
                                                         double enough_m) const;
  /// Prefetches the leaves that `begin_candidate_search` reads first. Most points need no others.
  void prefetch_leaves(const CandidateLeaves& list) const;

  /// The generalised winding number (Jacobson et al. 2013), with dipoles for distant clusters (Barill et al. 2018). It
  /// is about 1 inside a closed surface that is wound outwards, and about 0 outside. A point is inside if it exceeds
  /// 0.5. A result within 0.25 of 0.5 is computed again with finer clusters, and exactly if need be.
  [[nodiscard]] double winding_number(const Vec3& point) const;

  /// Finds where the straight path from `from` to `to` crosses triangles. Overwrites `crossings` with them, in the
  /// order of the path. At an edge or corner of a closed surface the path crosses exactly one triangle. A path that is
  /// not finite has no crossings.
  void find_crossings(const Vec3& from, const Vec3& to, std::vector<PathCrossing>& crossings) const;

  /// Calls `visit` once for each pair of triangles whose axis-aligned boxes overlap or nearly overlap.
  void for_each_close_pair(const std::function<void(int, int)>& visit) const;

  /// The outward normal of a triangle. Its length is twice the area in m2.
  [[nodiscard]] Vec3 area_normal(int triangle) const {
    const auto& [a, b, c] = m_corners[static_cast<std::size_t>(triangle)];
    return (b - a).cross(c - a);
  }

  /// Whether the triangle is very narrow. `closest_on_triangle` may then exceed the true distance by more than a search
  /// allows for. Bounds that assume that distance changes no faster than position (1-Lipschitz) do not hold for it.
  [[nodiscard]] bool is_sliver(int triangle) const;

  [[nodiscard]] std::size_t triangle_count() const { return m_corners.size(); }
  /// The corners of each triangle, in metres.
  [[nodiscard]] const std::array<Vec3, 3>* corners() const { return m_corners.data(); }
  /// Memory of the tree.
  [[nodiscard]] std::size_t bytes() const;

 private:
  friend class TriangleBvhBuilder;
  friend class BatchedClosestPoint;
  friend class MovingSurfaceTree;

  /// BvhSearch::slack for points with coordinates up to `reach` in the tree's frame, and up to `coordinate` in that of
  /// the mesh. Both are in the tree's unit of length.
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
