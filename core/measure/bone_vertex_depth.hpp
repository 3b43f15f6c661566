#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/contact/collision_backend.hpp"
#include "core/referee/referee_tree.hpp"

namespace musclebench {

/// The deepest vertex of a bone inside the muscle.
struct DeepestBoneVertex {
  double depth_m = 0;  ///< distance to the muscle's surface; 0: no vertex inside was found
  double bound_m = 0;  ///< no vertex is deeper: the depth, unless the budget was spent
  [[nodiscard]] bool complete() const { return bound_m <= depth_m; }
  int bone = -1;
  int vertex = -1;
  int triangle = -1;  ///< of the muscle, closest to it
};

/// Finds how deep the vertices of the bones are inside the muscle, which may be deformed and folded: inside is where
/// the winding number of the muscle's surface exceeds 0.5. Exact but for rounding.
///
/// A vertex whose closest muscle triangle has a node that the same bone carries belongs to the attachment, where bone
/// and muscle overlap by intention, and does not count.
class BoneVertexDepthMeter {
 public:
  /// `muscle`: the surface at rest, wound either way. `carriers`: for every node the bone that carries it, -1 for a
  /// free node.
  BoneVertexDepthMeter(std::span<const Bone> bones, const TriangleMesh& muscle, std::span<const int> carriers);

  /// `positions`: the muscle's nodes, finite; world frame. `budget`: of work, in the unit of RefereeTree; vertices that
  /// it does not suffice for are covered by `bound_m`, and come first in the next call. Caches from earlier calls
  /// change no bit of the depth while budgets suffice.
  DeepestBoneVertex measure(std::span<const RigidMotion> poses, std::span<const Vec3> positions,
                            long budget = std::numeric_limits<long>::max());

  /// Over all muscles, as they were in the last call.
  [[nodiscard]] const RefereeTree& muscle_tree() const { return m_tree; }

  /// Work of the last call, in the unit of RefereeTree.
  [[nodiscard]] long last_work() const { return m_work; }

  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Vertex {
    Vec3 point_m;  ///< rest frame
    int index;
    int slot = 0;             ///< of a triangle of the muscle that was near
    double safe_until_m = 0;  ///< outside until the muscle's travel exceeds this
  };
  /// Some vertices that lie close together.
  struct Cluster {
    int first, last;  ///< vertices first .. last - 1
    Vec3 centre_m;
    double radius_m;
    int slot = 0;
    double safe_until_m = 0;  ///< all outside until then
  };
  struct BoneVertices {
    std::vector<Vertex> vertices;
    std::vector<Cluster> clusters;
    std::vector<Vec3> last_m;  ///< the muscle's nodes in the bone's frame, in the last call
    /// Sum over the calls of the farthest that a node moved in the bone's frame.
    double travel_m = 0;
    std::size_t start = 0;  ///< the first cluster of the next call: where the budget was spent
  };
  /// A point whose side of the muscle's surface is known.
  struct KnownPoint {
    Vec3 point_m;
    double distance_m;
    SurfaceWinding winding;
    [[nodiscard]] bool inside() const { return winding.number > 0.5; }
  };

  static void divide(BoneVertices& bone, int first, int last);
  void follow(BoneVertices& bone, const RigidMotion& pose, std::span<const Vec3> positions) const;
  void measure_bone(int bone, const RigidMotion& pose, long budget);
  void measure_cluster(int bone, const RigidMotion& pose, Cluster& cluster);
  void measure_vertex(int bone, const RigidMotion& pose, Vertex& vertex, const KnownPoint& near);
  [[nodiscard]] double bound_of(const Cluster& cluster, const RigidMotion& pose) const;
  [[nodiscard]] bool is_attached(int bone, int slot) const;

  std::vector<Triangle> m_triangles;
  std::vector<int> m_carriers;
  RefereeTree m_tree;
  std::vector<BoneVertices> m_bones;
  DeepestBoneVertex m_best;
  double m_unmeasured_m = 0;  // bound of the vertices that the budget did not suffice for
  long m_work = 0;
};

}  // namespace musclebench
