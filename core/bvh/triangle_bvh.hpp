#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/base/prefetch.hpp"
#include "core/bvh/triangle_bvh_nodes.hpp"
#include "core/bvh/triangle_bvh_search.hpp"
#include "core/distance/triangle_distance.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

struct ClosestPoint {
  Vec3 point = Vec3::Zero();
  double distance_m = 0;
  int triangle = -1;
  Feature feature = Feature::face;
};

/// The closest point among listed triangles.
struct ClosestCandidate {
  ClosestPoint closest;
  /// No triangle outside the list can be as close, so this is what a search finds.
  bool certain = false;
  /// Positive: that was enough to know, and the closest point is not. No triangle at all is closer.
  double clearance_m = 0;
};

/// How far a point is at least from all triangles, and one of those that are near it.
struct Clearance {
  double distance_m = 0;
  int triangle = -1;
};

/// The triangles below one child of a node as seen from afar.
struct BvhCluster {
  Vec3 centre = Vec3::Zero();
  Vec3 area_normal = Vec3::Zero();
  double radius = 0;  ///< of the ball about `centre` that holds the triangles
};

/// A bounding-box tree over the triangles of a mesh, for closest points and winding numbers. Nodes and leaves are
/// compact floats, tested side by side with the vectors of the CPU that it runs on; they only prune, with a proven
/// slack (see triangle_bvh_search.cpp), and `closest_on_triangle` decides. So every answer is that of brute force, to
/// the bit, on any CPU: of all triangles the one whose squared distance by `closest_on_triangle` is the smallest, the
/// first of several. Keeps a copy of the triangles' corners; the mesh need not outlive it. Queries are const and safe
/// from several threads.
class TriangleBvh {
 public:
  explicit TriangleBvh(const TriangleMesh& mesh);

  /// The closest point within `max_distance_m`; nothing when the surface is farther away.
  [[nodiscard]] std::optional<ClosestPoint> closest_point(
      const Vec3& point, double max_distance_m = std::numeric_limits<double>::infinity()) const;

  /// The closest point, found faster from a triangle that is known to be near: the closest one of a neighbouring query.
  /// `triangle` is any triangle of the mesh; the answer is that of `closest_point`, to the bit.
  [[nodiscard]] ClosestPoint closest_point_from(const Vec3& point, int triangle) const;

  /// At least 0.9 of the distance to the closest triangle, less what floats may be off by, for much less than
  /// `closest_point_from`; `triangle` is any of the mesh, best one that was near the point before. 0 for a point beyond
  /// the reach of `list_candidate_leaves`.
  [[nodiscard]] Clearance clearance_from(const Vec3& point, int triangle) const;

  /// The closest point of one triangle.
  [[nodiscard]] ClosestOnTriangle closest_on(const Vec3& point, int triangle) const {
    const auto& [a, b, c] = m_corners[static_cast<std::size_t>(triangle)];
    return closest_on_triangle(point, a, b, c);
  }

  /// The leaves within `radius_m` of `point`, or the nearest of them, for `begin_candidate_search`. None for a point
  /// that is not finite or more than 1e12 times the mesh's size away.
  void list_candidate_leaves(const Vec3& point, double radius_m, CandidateLeaves& list) const;

  /// `closest_point`, to the bit, where the list is enough to tell; `list` is not empty and `certain` says whether.
  /// Else one of the nearest triangles, or none (-1). Where all triangles are certainly farther away than `enough_m`,
  /// only that is told, sooner. In two parts, so that those of several points can be done one part after the other and
  /// their ways through memory overlap: the first leaves to the second what may be the closest, asked for in memory.
  struct Search;
  void begin_candidate_search(const Vec3& point, const CandidateLeaves& list, Search& search) const;
  [[nodiscard]] ClosestCandidate finish_candidate_search(Search& search, const CandidateLeaves& list,
                                                         double enough_m) const;
  /// The way to what is listed begins to come from memory, for a search from near there.
  void fetch_way_to(const CandidateLeaves& list) const {
    for (const std::int32_t above : m_leaves[static_cast<std::size_t>(list.leaf[0])].above) {
      if (above < 0) {
        return;
      }
      prefetch(m_nodes[static_cast<std::size_t>(above)]);
    }
  }
  /// What `begin_candidate_search` will look at first begins to come from memory.
  void fetch(const CandidateLeaves& list) const {
    constexpr std::size_t looked_at = 4;  // of eight: a point is rarely farther from its list's place
    for (std::size_t i = 0; i < looked_at && list.leaf[i] >= 0; ++i) {
      prefetch(m_leaves[static_cast<std::size_t>(list.leaf[i])]);
    }
  }

  /// Generalised winding number (Jacobson et al. 2013), far clusters by their dipole (Barill et al. 2018): about 1
  /// inside an outward closed surface, 0 outside; inside is > 0.5. A result within 0.25 of 0.5 is refined, in the end
  /// exactly.
  [[nodiscard]] double winding_number(const Vec3& point) const;

  /// Calls `visit` with the indices of every two triangles whose boxes meet or nearly do, each pair once.
  void for_each_close_pair(const std::function<void(int, int)>& visit) const;

  /// Normal of a triangle by its winding, as long as twice its area; zero where it has none.
  [[nodiscard]] Vec3 area_normal(int triangle) const {
    const auto& [a, b, c] = m_corners[static_cast<std::size_t>(triangle)];
    return (b - a).cross(c - a);
  }

  /// Whether the triangle is so narrow that `closest_on_triangle` may answer it too far away by more than rounding: its
  /// distance at one place says nothing about that at another.
  [[nodiscard]] bool is_sliver(int triangle) const;

  [[nodiscard]] std::size_t triangle_count() const { return m_corners.size(); }
  /// Of each triangle, for `closest_on_triangles`.
  [[nodiscard]] const std::array<Vec3, 3>* corners() const { return m_corners.data(); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  friend class TriangleBvhBuilder;
  friend class BatchedClosestPoint;

  /// BvhSearch::slack for points up to `reach` from the middle and up to `coordinate` in the mesh's frame, along an
  /// axis, in the own unit.
  [[nodiscard]] float slack_for(double reach, double coordinate) const;
  /// The same for triangles, less what grows with their distance: that times `slack_growth`.
  [[nodiscard]] float near_slack_for(double reach, double coordinate) const;
  static constexpr float slack_growth = 27 * 0x1p-24F;
  void prepare(const Vec3& point, Search& search) const;
  [[nodiscard]] Search search_for(const Vec3& point) const;
  /// Whether floats do for the search.
  [[nodiscard]] bool within_horizon(const Vec3& point) const;
  void search_all(Search& search) const;
  /// Clusters count as far beyond `opening` times their radius.
  [[nodiscard]] double winding_number(const Vec3& point, double opening) const;
  [[nodiscard]] double leaf_winding(const BvhLeaf& leaf, const Vec3& point) const;

  std::vector<BvhNode> m_nodes;
  std::vector<BvhLeaf> m_leaves;
  std::vector<std::array<BvhCluster, bvh_width>> m_clusters;  ///< one a child of a node
  std::vector<std::array<Vec3, 3>> m_corners;                 ///< of each triangle
  std::vector<int> m_leaf_of;                                 ///< of each triangle

  // The tree's own frame is scale * (position - centre).
  Vec3 m_centre_m = Vec3::Zero();
  double m_scale = 1;         ///< a power of two, so that it rounds nothing
  double m_longest_side = 0;  ///< of a triangle, in the own unit
  double m_reach = 0;         ///< largest coordinate of a vertex in the mesh's frame, in the own unit
};

/// A search in floats with what has been decided in double so far.
struct TriangleBvh::Search : BvhSearch {
  const TriangleBvh* tree = nullptr;
  Vec3 exact_point;
  float moved = 0;  ///< from the place of a list, at most; own unit
  ClosestOnTriangle best;
  int best_triangle = -1;

  void offer(int index);
  void decide_listed();
  void narrow(double distance_m);
  [[nodiscard]] ClosestPoint answer() const;
};

}  // namespace musclebench
