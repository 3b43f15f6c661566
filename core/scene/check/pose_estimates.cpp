#include "core/scene/check/pose_estimates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace musclebench {

namespace {

/// Intervals of the whole motion: there and back over 90 degrees has then a pose each 11 degrees, between which a
/// muscle's surface moves by a few of its edges.
constexpr int motion_intervals = 16;

bool same_angles(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr double equal_rad = 1e-6;
  return std::ranges::equal(a, b, [](double x, double y) { return std::abs(x - y) <= equal_rad; });
}

}  // namespace

PoseEstimates::PoseEstimates(const Scene& scene)
    : m_rest(scene.muscle_mesh.vertices),
      m_bones(scene.bones.size()),
      m_weights(scene.muscle_mesh.vertices.size() * scene.bones.size(), 0.0) {
  choose_poses(scene);
  const std::vector<BoundNode> bound = scene.bound_nodes();
  for (const Muscle& muscle : scene.muscles) add_weights(muscle.body, bound);
}

void PoseEstimates::choose_poses(const Scene& scene) {
  std::size_t rotations = 0;
  for (const BoneMotion& motion : scene.motions) rotations += motion.rotations.size();
  std::vector<std::vector<double>> seen;
  m_bone_poses.emplace_back(m_bones);
  seen.emplace_back(rotations, 0.0);
  m_angles_rad.push_back(0);
  for (int i = 0; i <= motion_intervals; ++i) {
    const double progress = static_cast<double>(i) / motion_intervals;
    std::vector<double> angles;
    for (const BoneMotion& motion : scene.motions) {
      for (const BoneRotation& rotation : motion.rotations) angles.push_back(rotation.angle_rad(progress));
    }
    if (std::ranges::any_of(seen, [&](const auto& other) { return same_angles(angles, other); })) continue;
    seen.push_back(std::move(angles));
    const double frame_position = progress * (scene.loop.frames - scene.loop.rest_frames);
    m_angles_rad.push_back(scene.angle_rad(frame_position));
    scene.poses_at(frame_position, m_bone_poses.emplace_back());
  }
}

void PoseEstimates::add_weights(const Body& body, const std::vector<BoundNode>& bound) {
  constexpr std::size_t most_of_a_bone = 300;  // more of a patch change no weight that matters
  std::vector<std::vector<Vec3>> patches(m_bones);
  for (const BoundNode& node : bound) {
    if (body.has_node(node.node)) {
      patches[static_cast<std::size_t>(node.bone)].push_back(m_rest[static_cast<std::size_t>(node.node)]);
    }
  }
  for (int node = body.first_node; node < body.last_node; ++node) {
    double* weights = m_weights.data() + static_cast<std::size_t>(node) * m_bones;
    double sum = 0;
    for (std::size_t bone = 0; bone < m_bones; ++bone) {
      const std::vector<Vec3>& patch = patches[bone];
      const std::size_t stride = patch.size() / most_of_a_bone + 1;
      double nearest_m2 = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < patch.size(); i += stride) {
        nearest_m2 = std::min(nearest_m2, (patch[i] - m_rest[static_cast<std::size_t>(node)]).squaredNorm());
      }
      constexpr double smallest_m2 = 1e-18;
      weights[bone] = patch.empty() ? 0 : 1 / std::max(nearest_m2, smallest_m2);
      sum += weights[bone];
    }
    for (std::size_t bone = 0; bone < m_bones && sum > 0; ++bone) weights[bone] /= sum;
  }
  for (const BoundNode& node : bound) {
    if (!body.has_node(node.node)) continue;
    double* weights = m_weights.data() + static_cast<std::size_t>(node.node) * m_bones;
    std::fill(weights, weights + m_bones, 0.0);
    weights[node.bone] = 1;
  }
}

Vec3 PoseEstimates::position(std::size_t pose, int node) const {
  const Vec3& rest = m_rest[static_cast<std::size_t>(node)];
  const double* weights = m_weights.data() + static_cast<std::size_t>(node) * m_bones;
  Vec3 moved = Vec3::Zero();
  double sum = 0;
  for (std::size_t bone = 0; bone < m_bones; ++bone) {
    if (weights[bone] == 0) continue;
    moved += weights[bone] * m_bone_poses[pose][bone].apply(rest);
    sum += weights[bone];
  }
  return sum > 0 ? moved : rest;
}

std::vector<Vec3> PoseEstimates::positions(std::size_t pose, const Body& body) const {
  std::vector<Vec3> moved;
  for (int node = body.first_node; node < body.last_node; ++node) moved.push_back(position(pose, node));
  return moved;
}

}  // namespace musclebench
