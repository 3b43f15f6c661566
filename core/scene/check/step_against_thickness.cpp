#include "core/scene/check/step_against_thickness.hpp"

#include <algorithm>
#include <cmath>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// The largest angle that a bone turns by in one step of the loop.
double largest_step_rad(const Scene& scene, const BoneMotion& motion) {
  double largest = 0;
  double last = motion.angle_rad(0);
  for (int frame = 1; frame <= scene.loop.frames; ++frame) {
    const double next = motion.angle_rad(scene.progress_at(frame));
    largest = std::max(largest, std::abs(next - last));
    last = next;
  }
  return scene.loop.interpolate_poses ? largest / scene.loop.substeps : largest;
}

double distance_to_axis_m(const BoneMotion& motion, const Vec3& point) {
  return motion.axis.cross(point - motion.centre_m).norm();
}

/// Of a bone that stands still against the muscles: what moves is bound to bones that turn.
double largest_step_of_bound_nodes_m(const Scene& scene) {
  double farthest_m = 0;
  for (std::size_t bone = 0; bone < scene.motions.size(); ++bone) {
    const BoneMotion& motion = scene.motions[bone];
    if (motion.angles_rad.empty()) continue;
    const double step_rad = largest_step_rad(scene, motion);
    for (const BoundNode& bound : scene.bound_nodes()) {
      if (bound.bone != static_cast<int>(bone)) continue;
      const Vec3& node = scene.muscle_mesh.vertices[static_cast<std::size_t>(bound.node)];
      farthest_m = std::max(farthest_m, step_rad * distance_to_axis_m(motion, node));
    }
  }
  return farthest_m;
}

}  // namespace

StepAgainstThickness step_against_thickness(const Scene& scene, std::size_t bone) {
  const BoneMotion& motion = scene.motions[bone];
  StepAgainstThickness found;
  if (motion.angles_rad.empty()) {
    found.step_m = largest_step_of_bound_nodes_m(scene);
  } else {
    const double step_rad = largest_step_rad(scene, motion);
    const Eigen::AlignedBox3d box = box_near_muscles(scene);
    const TriangleMesh& mesh = scene.bones[bone].surface.mesh;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3 middle = (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3;
      if (box.contains(middle)) found.step_m = std::max(found.step_m, step_rad * distance_to_axis_m(motion, middle));
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
