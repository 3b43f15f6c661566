#include "core/scene/check/step_against_thickness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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

Eigen::AlignedBox3d near_muscles(const Scene& scene, double margin_m) {
  Eigen::AlignedBox3d box = bounding_box(scene.muscle_mesh.vertices);
  box.min() -= Vec3::Constant(margin_m);
  box.max() += Vec3::Constant(margin_m);
  return box;
}

}  // namespace

StepAgainstThickness step_against_thickness(const Scene& scene, std::size_t bone) {
  constexpr std::size_t most_samples = 2000;
  const BoneMotion& motion = scene.motions[bone];
  const TriangleMesh& mesh = scene.bones[bone].surface.mesh;
  const double diagonal_m = bounding_box(mesh.vertices).diagonal().norm();
  StepAgainstThickness found;
  const bool turns = !motion.angles_rad.empty();
  const double step_rad = turns ? largest_step_rad(scene, motion) : 0;
  found.step_m = turns ? 0 : largest_step_of_bound_nodes_m(scene);
  const Eigen::AlignedBox3d box = near_muscles(scene, 0.1 * bounding_box(scene.muscle_mesh.vertices).diagonal().norm());
  const auto corner = [&](std::size_t t, std::size_t k) -> const Vec3& {
    return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][k])];
  };
  const TriangleBvh& tree = scene.bones[bone].tree();
  std::vector<std::size_t> near;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 middle = (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3;
    if (!box.contains(middle)) continue;
    near.push_back(t);
    if (turns) found.step_m = std::max(found.step_m, step_rad * distance_to_axis_m(motion, middle));
  }
  if (near.empty() || !(found.step_m > 0)) return found;
  found.thinnest_m = std::numeric_limits<double>::infinity();
  double whole_area = 0;
  double thinner_area = 0;
  std::vector<PathCrossing> crossings;
  const std::size_t stride = (near.size() + most_samples - 1) / most_samples;
  for (std::size_t i = 0; i < near.size(); i += stride) {
    const std::size_t t = near[i];
    const Vec3 normal = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).stableNormalized();
    const Vec3 middle = (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3;
    // A little inside, so that the triangle itself is not met.
    const Vec3 from = middle - 1e-7 * diagonal_m * normal;
    tree.find_crossings(from, middle - diagonal_m * normal, crossings);
    if (crossings.empty() || crossings.front().entering) continue;  // a hole, or a sheet: no thickness to tell
    const double thickness_m = crossings.front().share * diagonal_m;
    const double area = tree.area_normal(static_cast<int>(t)).norm();
    ++found.samples;
    whole_area += area;
    thinner_area += thickness_m < found.step_m ? area : 0;
    found.thinnest_m = std::min(found.thinnest_m, thickness_m);
  }
  if (found.samples == 0) found.thinnest_m = 0;
  if (whole_area > 0) found.thinner_share = thinner_area / whole_area;
  return found;
}

}  // namespace musclebench
