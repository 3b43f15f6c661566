#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/collision_backend.hpp"
#include "core/referee/contact_comparison.hpp"
#include "core/referee/referee_tree.hpp"

namespace musclebench {

/// A point's distance to the surface of a bone.
struct SurfaceDistance {
  double signed_distance_m = 0;         ///< negative inside
  Vec3 closest_point_m = Vec3::Zero();  ///< on the surface
  /// Unit, out of the bone: for a point inside the direction to the closest point. On the surface the normal of the
  /// face (zero for a face without area).
  Vec3 normal = Vec3::Zero();
};

/// Work of a call of Referee::judge; what earlier calls have cached is not counted.
struct RefereeEffort {
  long distance_queries = 0;
  long winding_numbers = 0;
  long work = 0;  ///< of the trees, in the unit of RefereeTree
};

/// The ground truth: the exact signed distance of points to bones, in double precision, by code that no backend shares.
///
/// Inside is where the winding number of the bone's surface exceeds 0.5 (Jacobson et al. 2013); its size is the
/// distance to the nearest triangle. This holds for overlapping components, non-manifold edges and sheets without
/// thickness. Inside an overlap of two components the nearest triangle, hence the depth and the normal, may belong to a
/// face that lies inside the other component.
///
/// A surface that is not closed has a winding number too, but it changes away from the surface. Such a bone is judged
/// by the same means, where a side is cached only for as long as the surface's boundary allows (SurfaceWinding),
/// and at a cost that grows with the number of boundary edges.
class Referee {
 public:
  /// Distance reuse: `judge` caches each node's distance to each bone, and queries again only when the node has moved,
  /// in the bone's frame, so far that its sign may have changed. The answer is the same to the bit.
  enum class DistanceReuse { on, off };

  /// `nodes`: one more than the largest node index to be judged. `bones` need not outlive the referee. `threads` >= 1;
  /// the answer does not depend on it. Throws InputError that names the bone when its surface has no triangles.
  Referee(std::span<const Bone> bones, int nodes, int threads = 1, DistanceReuse reuse = DistanceReuse::on);

  /// Signed distance of `rest_point`, a finite point in the rest frame of bone number `bone`, in metres. Also signed
  /// closer to the surface than the touching distance: what `judge` counts as touching may be negative.
  [[nodiscard]] double signed_distance(int bone, const Vec3& rest_point) const;

  /// The same with the closest point and the normal, both in the rest frame. Adds to `work`, where it is given, in the
  /// unit of RefereeTree.
  [[nodiscard]] SurfaceDistance closest(int bone, const Vec3& rest_point, long* work = nullptr) const;

  /// The tree over bone number `bone`, for other queries.
  [[nodiscard]] const RefereeTree& tree(int bone) const { return m_trees[static_cast<std::size_t>(bone)]; }

  /// A lower bound of the distance from `rest_point` to the surface of bone number `bone`, from what `judge` has cached
  /// of `node`, without a query; 0 or less where that gives none.
  [[nodiscard]] double least_distance(int bone, int node, const Vec3& rest_point) const;

  /// Finds the true contacts of `nodes` (ascending indices into `positions`; world frame, metres) with the bones at
  /// `poses`, into `truth`, which is overwritten: one for every bone and node inside it and not closer to its surface
  /// than `touching_distance_m`, ordered by bone, then by node. A node at a position that is not finite is in no bone.
  void judge(std::span<const RigidMotion> poses, std::span<const Vec3> positions, std::span<const int> nodes,
             std::vector<Contact>& truth);

  /// Effort of the last call of `judge`.
  [[nodiscard]] RefereeEffort last_effort() const { return m_effort; }

  /// Bytes of the trees and of the cached distances of the nodes.
  [[nodiscard]] std::size_t bytes() const;

 private:
  /// Result of the last query of a node and a bone.
  struct NodeCache {
    Vec3 point_m = Vec3::Zero();  ///< the node's position then, relative to the tree's centre
    double clearance_m = -1;      ///< lower bound of the distance to the surface there; negative: not queried yet
    double steady_m = 0;          ///< movement for which `inside` holds away from the surface, see SurfaceWinding
    int triangle = -1;            ///< slot of the closest one; -1: unknown
    bool inside = false;
  };

  [[nodiscard]] bool examine(int bone, const Vec3& point, NodeCache& cache, SurfaceDistance& found,
                             RefereeEffort& effort) const;
  void judge_bone(int bone, const RigidMotion& pose, std::span<const Vec3> positions, std::span<const int> nodes);

  std::vector<RefereeTree> m_trees;
  std::vector<double> m_touching_m;                   // by bone
  std::vector<std::vector<NodeCache>> m_node_caches;  // by bone, by node
  std::vector<Contact> m_found;                       // by index in `nodes`, valid where m_inside
  std::vector<unsigned char> m_inside;
  RefereeEffort m_effort;
  [[maybe_unused]] int m_threads;  // unused where the compiler has no OpenMP
  bool m_reuses_distances;
};

}  // namespace musclebench
