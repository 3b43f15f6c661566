#include "core/scene/check/step_against_thickness.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// The largest steps of the loop that a bone makes, one a rotation.
class LargestSteps {
 public:
  LargestSteps(const Scene& scene, const BoneMotion& motion) : m_motion(motion) {
    for (const BoneRotation& rotation : motion.rotations) {
      double largest_rad = 0;
      double last_rad = rotation.angle_rad(0);
      for (int frame = 1; frame <= scene.loop.frames; ++frame) {
        const double next_rad = rotation.angle_rad(scene.progress_at(frame));
        largest_rad = std::max(largest_rad, std::abs(next_rad - last_rad));
        last_rad = next_rad;
      }
      m_steps_rad.push_back(scene.loop.interpolate_poses ? largest_rad / scene.loop.substeps : largest_rad);
    }
  }

  /// Of a point of the bone, as if all rotations made their largest step at once and about their axes at rest.
  [[nodiscard]] double of_point_m(const Vec3& point) const {
    double step_m = 0;
    for (std::size_t i = 0; i < m_steps_rad.size(); ++i) {
      const BoneRotation& rotation = m_motion.rotations[i];
      step_m += m_steps_rad[i] * rotation.axis.cross(point - rotation.centre_m).norm();
    }
    return step_m;
  }

 private:
  const BoneMotion& m_motion;
  std::vector<double> m_steps_rad;
};

/// Of a bone that stands still against the muscles: what moves is bound to bones that turn.
double largest_step_of_bound_nodes_m(const Scene& scene) {
  double farthest_m = 0;
  for (std::size_t bone = 0; bone < scene.motions.size(); ++bone) {
    const BoneMotion& motion = scene.motions[bone];
    if (motion.rotations.empty()) continue;
    const LargestSteps steps(scene, motion);
    for (const BoundNode& bound : scene.bound_nodes()) {
      if (bound.bone != static_cast<int>(bone)) continue;
      const Vec3& node = scene.muscle_mesh.vertices[static_cast<std::size_t>(bound.node)];
      farthest_m = std::max(farthest_m, steps.of_point_m(node));
    }
  }
  return farthest_m;
}

}  // namespace

StepAgainstThickness step_against_thickness(const Scene& scene, std::size_t bone) {
  const BoneMotion& motion = scene.motions[bone];
  StepAgainstThickness found;
  if (motion.rotations.empty()) {
    found.step_m = largest_step_of_bound_nodes_m(scene);
  } else {
    const LargestSteps steps(scene, motion);
    const Eigen::AlignedBox3d box = box_near_muscles(scene);
    const TriangleMesh& mesh = scene.bones[bone].surface.mesh;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3 middle = (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3;
      if (box.contains(middle)) found.step_m = std::max(found.step_m, steps.of_point_m(middle));
    }
  }
  if (found.step_m > 0) {
    found.thinner = share_thinner_than(found.step_m, sample_thickness(scene.bones[bone], box_near_muscles(scene)));
  }
  return found;
}

Eigen::AlignedBox3d box_near_muscles(const Scene& scene) {
  Eigen::AlignedBox3d box = bounding_box(scene.muscle_mesh.vertices);
  const double margin_m = 0.1 * box.diagonal().norm();
  box.min() -= Vec3::Constant(margin_m);
  box.max() += Vec3::Constant(margin_m);
  return box;
}

}  // namespace musclebench
