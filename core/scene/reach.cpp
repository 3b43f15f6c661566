#include "core/scene/reach.hpp"

#include <algorithm>
#include <limits>

#include "core/mesh/mesh_size.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

namespace {

/// What a muscle may move beyond the box that its bound nodes let expect, over the diagonal of its box at rest.
constexpr double margin_share = 0.25;

Eigen::AlignedBox3d moved(const Eigen::AlignedBox3d& box, const RigidMotion& pose) {
  const Vec3 centre = pose.apply(box.center());
  const Vec3 half = pose.rotation.cwiseAbs() * (0.5 * box.sizes());
  return {centre - half, centre + half};
}

Eigen::AlignedBox3d grown(const Eigen::AlignedBox3d& box, double by_m) {
  return {box.min() - Vec3::Constant(by_m), box.max() + Vec3::Constant(by_m)};
}

double distance_m(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  return a.isEmpty() || b.isEmpty() ? std::numeric_limits<double>::infinity() : a.exteriorDistance(b);
}

/// Where a muscle is expected at any time.
class ExpectedMuscle {
 public:
  ExpectedMuscle(const Scene& scene, const Body& body, const std::vector<BoundNode>& bound)
      : m_at_rest(bounding_box(scene.vertices_of(body))), m_bound(scene.bones.size()) {
    for (const BoundNode& node : bound) {
      if (!body.has_node(node.node)) continue;
      m_bound[static_cast<std::size_t>(node.bone)].extend(
          scene.muscle_mesh.vertices[static_cast<std::size_t>(node.node)]);
    }
    const Eigen::AlignedBox3d of_bound = box_of_bound(std::vector<RigidMotion>(scene.bones.size()));
    if (!of_bound.isEmpty()) {
      m_excess_m =
          std::max((of_bound.min() - m_at_rest.min()).maxCoeff(), (m_at_rest.max() - of_bound.max()).maxCoeff());
    }
  }

  [[nodiscard]] double margin_m() const { return margin_share * m_at_rest.diagonal().norm(); }

  [[nodiscard]] Eigen::AlignedBox3d box(const std::vector<RigidMotion>& poses) const {
    Eigen::AlignedBox3d box = box_of_bound(poses);
    if (box.isEmpty()) return m_at_rest;
    box.min() -= Vec3::Constant(m_excess_m);
    box.max() += Vec3::Constant(m_excess_m);
    return box;
  }

 private:
  [[nodiscard]] Eigen::AlignedBox3d box_of_bound(const std::vector<RigidMotion>& poses) const {
    Eigen::AlignedBox3d box;
    for (std::size_t bone = 0; bone < m_bound.size(); ++bone) {
      if (!m_bound[bone].isEmpty()) box.extend(moved(m_bound[bone], poses[bone]));
    }
    return box;
  }

  Eigen::AlignedBox3d m_at_rest;
  std::vector<Eigen::AlignedBox3d> m_bound;  ///< by bone, in its rest frame: around the nodes that it carries
  double m_excess_m = 0;                     ///< of the muscle over them, at rest
};

/// Those that attachments bind; where a bone's first contacts will be bound, all nodes in its box.
std::vector<BoundNode> expected_bound_nodes(const Scene& scene) {
  if (!scene.attach_at_first_contact) return scene.bound_nodes();
  std::vector<BoundNode> bound;
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    const Eigen::AlignedBox3d box = bounding_box(scene.bones[bone].surface.mesh.vertices);
    for (std::size_t node = 0; node < scene.muscle_mesh.vertices.size(); ++node) {
      if (box.contains(scene.muscle_mesh.vertices[node])) {
        bound.push_back({static_cast<int>(node), static_cast<int>(bone)});
      }
    }
  }
  return bound;
}

}  // namespace

std::vector<BoneReach> predict_reach(const Scene& scene) {
  // Without a motion for each bone, as of a scene put together for a replay, nothing is known of its poses.
  if (scene.motions.size() != scene.bones.size()) return std::vector<BoneReach>(scene.bones.size());
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Bone& bone : scene.bones) boxes.push_back(bounding_box(bone.surface.mesh.vertices));
  std::vector<ExpectedMuscle> muscles;
  const std::vector<BoundNode> bound = expected_bound_nodes(scene);
  for (const Body& body : scene.bodies()) muscles.emplace_back(scene, body, bound);

  std::vector<BoneReach> reach(scene.bones.size(),
                               {std::numeric_limits<double>::infinity(), 0, false, Eigen::AlignedBox3d()});
  for (const ExpectedMuscle& muscle : muscles) {
    for (BoneReach& each : reach) each.margin_m = std::max(each.margin_m, muscle.margin_m());
  }
  std::vector<RigidMotion> poses;
  for (int frame = 0; frame <= scene.loop.frames; ++frame) {
    scene.poses_at(frame, poses);
    for (const ExpectedMuscle& muscle : muscles) {
      const Eigen::AlignedBox3d expected = muscle.box(poses);
      for (std::size_t bone = 0; bone < boxes.size(); ++bone) {
        reach[bone].distance_m =
            std::min(reach[bone].distance_m, distance_m(moved(boxes[bone], poses[bone]), expected));
        reach[bone].box.extend(grown(moved(expected, poses[bone].inverse()), muscle.margin_m()));
      }
    }
  }
  for (std::size_t bone = 0; bone < reach.size(); ++bone) {
    // Of an open bone the inside may extend beyond its box, and where it ends depends on what is asked.
    const RepairedMesh& surface = scene.bones[bone].surface;
    const bool closed = surface.known_closed || is_closed(surface.mesh);
    reach[bone].is_untouched = closed && reach[bone].distance_m > reach[bone].margin_m;
    if (!closed) reach[bone].box = unbounded_box();
  }
  return reach;
}

std::vector<Eigen::AlignedBox3d> expected_boxes(const std::vector<BoneReach>& reach) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const BoneReach& each : reach) boxes.push_back(each.is_untouched ? Eigen::AlignedBox3d() : each.box);
  return boxes;
}

}  // namespace musclebench
