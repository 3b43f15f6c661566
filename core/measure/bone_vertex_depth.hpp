#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/collision_backend.hpp"
#include "core/referee/referee_tree.hpp"

namespace musclebench {

/// The deepest vertex of a bone inside the muscle.
struct DeepestBoneVertex {
  double depth_m = 0;  ///< distance to the muscle's surface; 0: no vertex is inside
  int bone = -1;
  int vertex = -1;
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

  /// `positions`: the muscle's nodes, finite; world frame. What is kept from earlier calls changes no bit of the depth.
  DeepestBoneVertex measure(std::span<const RigidMotion> poses, std::span<const Vec3> positions);

  /// Closest-point queries of the last call.
  [[nodiscard]] long last_queries() const { return m_queries; }

  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Vertex {
    Vec3 point_m;  ///< rest frame
    int index;
    int place = 0;            ///< of a triangle of the muscle that was near
    double safe_until_m = 0;  ///< outside until the muscle's way exceeds this
  };
  /// Some vertices that lie close together.
  struct Cluster {
    int first, last;  ///< vertices first .. last - 1
    Vec3 centre_m;
    double radius_m;
    int place = 0;
    double safe_until_m = 0;  ///< all outside until then
  };
  struct BoneVertices {
    std::vector<Vertex> vertices;
    std::vector<Cluster> clusters;
    std::vector<Vec3> last_m;  ///< the muscle's nodes in the bone's frame, in the last call
    /// Sum over the calls of the farthest that a node moved in the bone's frame.
    double way_m = 0;
  };
  /// Where a point is relative to the muscle; the side is found only when asked for.
  struct Place {
    Vec3 point_m;
    double distance_m;
    bool inside;
  };

  static void divide(BoneVertices& bone, int first, int last);
  void follow(BoneVertices& bone, const RigidMotion& pose, std::span<const Vec3> positions) const;
  void measure_cluster(int bone, const RigidMotion& pose, Cluster& cluster);
  void measure_vertex(int bone, const RigidMotion& pose, Vertex& vertex, const Place& near);
  [[nodiscard]] bool is_attached(int bone, int place) const;

  std::vector<Triangle> m_triangles;
  std::vector<int> m_carriers;
  RefereeTree m_tree;
  std::vector<BoneVertices> m_bones;
  DeepestBoneVertex m_best;
  long m_queries = 0;
};

}  // namespace musclebench
