#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/scene/scene.hpp"

namespace musclebench {

/// Where the nodes of all muscles are at some poses of the motion, told by kinematics alone: a node follows the bones
/// that its muscle is bound to, the more the nearer it is to their bound nodes (inverse squared distances, at rest). A
/// bound node follows its bone exactly; a muscle that nothing binds stays. Contact is left out, so that a muscle which
/// is bent about a bone passes through it: what is inside one would lie on its surface.
class PoseEstimates {
 public:
  explicit PoseEstimates(const Scene& scene);

  /// The first one is at rest; poses that the motion passes twice count once.
  [[nodiscard]] std::size_t count() const { return m_bone_poses.size(); }
  [[nodiscard]] const std::vector<RigidMotion>& bone_poses(std::size_t pose) const { return m_bone_poses[pose]; }
  /// The largest angle of a bone there.
  [[nodiscard]] double angle_rad(std::size_t pose) const { return m_angles_rad[pose]; }
  /// Of any node, in the world frame.
  [[nodiscard]] Vec3 position(std::size_t pose, int node) const;
  [[nodiscard]] std::vector<Vec3> positions(std::size_t pose, const Body& body) const;

 private:
  void choose_poses(const Scene& scene);
  void add_weights(const Body& body, const std::vector<BoundNode>& bound);

  const std::vector<Vec3>& m_rest;
  std::size_t m_bones;
  std::vector<std::vector<RigidMotion>> m_bone_poses;  ///< by pose, then bone
  std::vector<double> m_angles_rad;                    ///< by pose
  std::vector<double> m_weights;                       ///< by node, then bone; they add up to 1, or are all 0
};

}  // namespace musclebench
