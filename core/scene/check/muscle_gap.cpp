#include "core/scene/check/muscle_gap.hpp"

#include <algorithm>
#include <limits>

#include "core/bvh/triangle_bvh.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

constexpr double far_away = std::numeric_limits<double>::infinity();

/// One muscle at one pose.
struct PosedMuscle {
  TriangleMesh mesh;
  TriangleBvh tree;
  Eigen::AlignedBox3d box;
  double touching_m;

  explicit PosedMuscle(TriangleMesh posed)
      : mesh(std::move(posed)), tree(mesh), box(bounding_box(mesh.vertices)), touching_m(touching_distance_m(mesh)) {}
};

struct NodeGap {
  double least_m = far_away;
  int inside = 0;
};

/// Nodes of `one` near `other`. `reach_m`: beyond it nothing is measured.
void add_nodes(const PosedMuscle& one, const PosedMuscle& other, double reach_m, NodeGap& gap) {
  for (const Vec3& node : one.mesh.vertices) {
    if (other.box.squaredExteriorDistance(node) > reach_m * reach_m) continue;
    const bool inside = other.box.contains(node) && other.tree.winding_number(node) > 0.5;
    // Farther outside than what is found already it need not be known how far.
    const auto closest = other.tree.closest_point(node, inside ? far_away : std::clamp(gap.least_m, 0.0, reach_m));
    if (!closest) continue;
    gap.inside += inside && closest->distance_m > other.touching_m ? 1 : 0;
    gap.least_m = std::min(gap.least_m, inside ? -closest->distance_m : closest->distance_m);
  }
}

}  // namespace

std::vector<MuscleGap> muscle_gaps(const Scene& scene, const PoseEstimates& poses, double reach_m) {
  std::vector<MuscleGap> gaps;
  const auto count = static_cast<int>(scene.muscles.size());
  for (int first = 0; first < count; ++first) {
    for (int second = first + 1; second < count; ++second) gaps.push_back({{first, second}, far_away, 0, far_away, 0});
  }
  for (std::size_t pose = 0; pose < poses.count() && !gaps.empty(); ++pose) {
    std::vector<PosedMuscle> posed;
    for (const Muscle& muscle : scene.muscles) {
      TriangleMesh mesh = scene.mesh_of(muscle.body);
      mesh.vertices = poses.positions(pose, muscle.body);
      posed.emplace_back(std::move(mesh));
    }
    for (MuscleGap& gap : gaps) {
      const PosedMuscle& first = posed[static_cast<std::size_t>(gap.muscles.first)];
      const PosedMuscle& second = posed[static_cast<std::size_t>(gap.muscles.second)];
      if (first.box.squaredExteriorDistance(second.box) > reach_m * reach_m) continue;
      NodeGap nodes;
      add_nodes(first, second, reach_m, nodes);
      add_nodes(second, first, reach_m, nodes);
      if (pose == 0) {
        gap.rest_m = nodes.least_m;
        gap.rest_nodes_inside = nodes.inside;
      }
      if (nodes.least_m < gap.least_m) {
        gap.least_m = nodes.least_m;
        gap.least_angle_rad = poses.angle_rad(pose);
      }
    }
  }
  std::erase_if(gaps, [](const MuscleGap& gap) { return gap.least_m == far_away; });
  return gaps;
}

}  // namespace musclebench
