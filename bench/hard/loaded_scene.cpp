#include "bench/hard/loaded_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "core/mesh/surface_volume.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

Scene load(const LoadedScene& scene) {
  SceneChoice choice = scene_of(scene.name);
  choice.loop_overrides = scene.loop;
  choice.mesh_overrides = scene.meshes;
  for (const auto& [effect, values] : scene.effects) {
    choice.effect_overrides.push_back({.location = "hard case", .name = effect, .values = values});
  }
  return load_scene(choice);
}

Vec3 middle_of(std::span<const Vec3> positions, const Body& body) {
  Vec3 sum = Vec3::Zero();
  for (int node = body.first_node; node < body.last_node; ++node) sum += positions[static_cast<std::size_t>(node)];
  return sum / (body.last_node - body.first_node);
}

double late_move(const MovedScene& run, std::size_t frames) {
  const std::size_t last = run.result.snapshots.size() - 1;
  double largest_m = 0;
  for (std::size_t frame = last - frames + 1; frame <= last; ++frame) {
    const double moved_m = run.largest_move_m(frame - 1, frame);
    if (!(moved_m <= largest_m)) largest_m = moved_m;
  }
  return largest_m / run.diagonal_m();
}

double frame_s(const Scene& scene) { return scene.loop.time_step_s * scene.loop.substeps; }

std::vector<double> node_masses_kg(const Scene& scene) {
  std::vector<double> masses(scene.muscle_mesh.vertices.size());
  for (const Muscle& muscle : scene.muscles) {
    std::fill(masses.begin() + muscle.body.first_node, masses.begin() + muscle.body.last_node,
              node_mass_kg(scene, muscle));
  }
  return masses;
}

HardFigures late_force_figures(const MovedScene& run, int frames, const LoadOfBones& expected) {
  if (!run.result.force_obstacles.contacts.empty()) return {};
  Vec3 force_n = Vec3::Zero();
  double normal_n = 0;
  double friction_n = 0;
  for (const ForceRow& row : run.result.forces) {
    if (row.source != ForceSource::bone || row.frame <= run.result.records.back().frame - frames) continue;
    force_n += row.force_n / frames;
    normal_n += *row.normal_n / frames;
    friction_n += *row.friction_n / frames;
  }
  const std::vector<double> masses_kg = node_masses_kg(run.scene);
  const double weight_n = 9.80665 * std::accumulate(masses_kg.begin(), masses_kg.end(), 0.0);
  const auto off = [&](double told_n, double share) { return std::abs(told_n - share * weight_n) / weight_n; };
  HardFigures figures{
      {"force of bones, off the weight by a share of it", (force_n - Vec3(0, 0, weight_n)).norm() / weight_n, 0.01}};
  if (expected.normal)
    figures.push_back({"normal force, off its share of the weight", off(normal_n, *expected.normal), 0.01});
  if (expected.friction)
    figures.push_back({"friction, off its share of the weight", off(friction_n, *expected.friction), 0.01});
  return figures;
}

void move_straight(Scene& scene, std::size_t bone, const StraightCourse& course) {
  constexpr double arm_m = 100;
  BoneRotation rotation;
  rotation.axis = course.direction.unitOrthogonal();
  // A turn by a small angle moves what is near the origin by axis x arm, which is to be along the direction.
  rotation.centre_m = -arm_m * course.direction.cross(rotation.axis).normalized();
  rotation.times = course.times;
  for (const double displacement_m : course.displacement_m)
    rotation.angles_rad.push_back(std::asin(displacement_m / arm_m));
  rotation.there_and_back = false;
  scene.motions[bone].rotations = {rotation};
}

void place_bone(Scene& scene, std::size_t bone, const Vec3& by_m, const Vec3& scale) {
  for (TriangleMesh* mesh : {&scene.bones[bone].surface.mesh, &scene.bone_meshes[bone].mesh}) {
    for (Vec3& vertex : mesh->vertices) vertex = vertex.cwiseProduct(scale) + by_m;
  }
}

void swap_muscles(Scene& scene) {
  const std::vector<Muscle> muscles = scene.muscles;
  const std::vector<TriangleMesh> meshes = {scene.mesh_of(muscles[0].body), scene.mesh_of(muscles[1].body)};
  scene.muscles.clear();
  scene.muscle_mesh = {};
  for (const std::size_t old : {1U, 0U}) {
    Muscle& muscle = scene.add_muscle(muscles[old].body.name, meshes[old]);
    muscle.velocity_m_per_s = muscles[old].velocity_m_per_s;
  }
  for (Attachment& attachment : scene.attachments) {
    const int first_before = muscles[attachment.muscle].body.first_node;
    attachment.muscle = 1 - attachment.muscle;
    for (int& node : attachment.nodes) node += scene.muscles[attachment.muscle].body.first_node - first_before;
  }
}

double gap_of_swapped_m(const MovedScene& run, const MovedScene& swapped) {
  const std::vector<Vec3>& one = run.result.snapshots.back().positions;
  std::vector<Vec3> other = swapped.result.snapshots.back().positions;
  const auto of_first = run.scene.muscles.back().body.last_node - run.scene.muscles.back().body.first_node;
  std::rotate(other.begin(), other.begin() + of_first, other.end());
  return largest_gap_m(one, other);
}

HardFigure bound_figure(const MovedScene& run) {
  double largest_m = 0;
  for (const Snapshot& shape : run.result.snapshots) {
    for (const BoundNode& bound : run.result.bound_nodes) {
      const auto node = static_cast<std::size_t>(bound.node);
      const Vec3 carried =
          shape.bone_poses[static_cast<std::size_t>(bound.bone)].apply(run.scene.muscle_mesh.vertices[node]);
      largest_m = std::max(largest_m, (shape.positions[node] - carried).norm());
    }
  }
  return {"drift of a bound node in its bone, over the diagonal",
          run.result.bound_nodes.empty() ? 1 : largest_m / run.diagonal_m(), 1e-12};
}

}  // namespace musclebench
