#include "core/scene/scene.hpp"

#include <algorithm>
#include <cmath>

namespace musclebench {

void Scene::poses_at(double frame_position, std::vector<RigidMotion>& poses) const {
  poses.resize(motions.size());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    poses[i] = motions[i].pose(frame_position / loop.frames);
  }
}

double Scene::angle_rad(double frame_position) const {
  double largest = 0;
  for (const BoneMotion& motion : motions) {
    const double angle = motion.angle_rad(frame_position / loop.frames);
    largest = std::abs(angle) > std::abs(largest) ? angle : largest;
  }
  return largest;
}

std::vector<BoundNode> Scene::bound_nodes() const {
  std::vector<BoundNode> bound;
  for (const Attachment& attachment : attachments) {
    for (const int node : attachment.nodes) {
      bound.push_back({node, attachment.bone});
    }
  }
  std::stable_sort(bound.begin(), bound.end(), [](const BoundNode& a, const BoundNode& b) { return a.node < b.node; });
  bound.erase(
      std::unique(bound.begin(), bound.end(), [](const BoundNode& a, const BoundNode& b) { return a.node == b.node; }),
      bound.end());
  return bound;
}

std::vector<FibreSegment> Scene::fibres_with(const std::vector<BoundNode>& bound) const {
  if (!fibres_between_attachments) {
    return fibres;
  }
  constexpr int most_segments = 1000;
  const int origin_bone = attachments.empty() ? 0 : attachments.front().bone;
  std::vector<int> origin;
  std::vector<int> insertion;
  for (const BoundNode& node : bound) {
    (node.bone == origin_bone ? origin : insertion).push_back(node.node);
  }
  return fibres_between(muscle.mesh, origin, insertion, most_segments);
}

std::vector<ParameterSpec> loop_parameters() {
  return {
      {"frames", std::int64_t{314}, "frames of the whole motion", 1, 1e7, {}},
      {"substeps", std::int64_t{3}, "substeps a frame, each with one prediction and one velocity update", 1, 1e6, {}},
      {"iterations", std::int64_t{1}, "passes over constraints, detection and response a substep", 1, 1e6, {}},
      {"time_step_s", 1e-3, "time of one substep", 1e-9, 1e3, {}},
      {"damping_per_s", 0.0, "velocities decay as exp(-damping time)", 0, 1e9, {}},
      {"node_mass_kg", 1.0, "mass of every node (unless a density is given)", 1e-12, 1e12, {}},
      {"density_kg_per_m3",
       0.0,
       "density of the muscle, whose mass its nodes share evenly; 0: use node_mass_kg",
       0,
       1e6,
       {}},
      {"bone_motion",
       std::string("per_frame"),
       "per_frame: bones jump to the frame's pose in its first substep (paper); interpolated: they move in every "
       "substep",
       -1e300,
       1e300,
       {"per_frame", "interpolated"}},
  };
}

LoopParameters loop_from(const Parameters& parameters) {
  LoopParameters loop;
  loop.frames = static_cast<int>(parameters.integer("frames"));
  loop.substeps = static_cast<int>(parameters.integer("substeps"));
  loop.iterations = static_cast<int>(parameters.integer("iterations"));
  loop.time_step_s = parameters.number("time_step_s");
  loop.damping_per_s = parameters.number("damping_per_s");
  loop.node_mass_kg = parameters.number("node_mass_kg");
  loop.density_kg_per_m3 = parameters.number("density_kg_per_m3");
  loop.interpolate_poses = parameters.word("bone_motion") == "interpolated";
  return loop;
}

}  // namespace musclebench
