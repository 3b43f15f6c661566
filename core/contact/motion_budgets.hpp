#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// What nodes may still move before they can touch a bone. A node that was found at a distance d from a bone keeps a
/// ball of radius d about the place, in the bone's rest frame; as long as node and bone together have not moved it out
/// of the ball, it is free and need not be asked about. So the cost of a detection falls with the motion of a step, and
/// its answer stays the same to the bit: a ball is granted only as large as its owner vouches for, and shrunk by all
/// rounding on the way.
///
/// Balls are held in single precision about the middle of each bone; a sweep over them costs about what one bit of a
/// voxel grid does.
class MotionBudgets {
 public:
  /// By how much `spent` is longer than `nodes` while it is filled.
  static constexpr std::size_t room_behind = 16;

  /// Spends all budgets. Keeps nothing of `bones` but where they are; `nodes` is the number of positions.
  void reset(std::span<const Bone> bones, std::size_t nodes);

  /// The places in `nodes` (ascending) of those that have left their balls about `bone`, or never had one, into
  /// `spent`, ascending. `positions` (of all nodes) are in the world frame, in metres, and may be anything, also not
  /// finite (then spent).
  void collect_spent(int bone, const RigidMotion& pose, std::span<const Vec3> positions, std::span<const int> nodes,
                     std::vector<int>& spent);

  /// Promises that `node` is free of `bone` wherever it is nearer than `clearance_m` to `rest_point` (in the bone's
  /// rest frame). May be called for different nodes by several threads at once. A clearance that is not positive leaves
  /// it without a budget.
  void grant(int bone, int node, const Vec3& rest_point, double clearance_m);

  /// How far `rest_point` (in the bone's rest frame) is outside the node's ball; infinite without a ball. A ball about
  /// that point that no surface reaches into and that is larger overlaps the node's: then it is as free.
  [[nodiscard]] double gap_m(int bone, int node, const Vec3& rest_point) const;

  /// Of the node's ball; 0 without one.
  [[nodiscard]] double radius_m(int bone, int node) const {
    return static_cast<double>(m_bones[static_cast<std::size_t>(bone)].radius_m[static_cast<std::size_t>(node)]);
  }

  /// That `reset` was told of.
  [[nodiscard]] std::size_t nodes() const { return m_nodes; }
  [[nodiscard]] std::size_t bytes() const;

  /// About a bone's middle, in its rest frame, by node.
  struct Balls {
    Vec3 middle_m;
    std::vector<float> x, y, z, radius_m;
  };

 private:
  void plan_sweep(std::span<const int> nodes);
  void collect_one_by_one(const Balls& balls, const RigidMotion& pose, std::span<const Vec3> positions,
                          std::span<const int> nodes, std::vector<int>& spent) const;

  std::vector<Balls> m_bones;
  std::size_t m_nodes = 0;
  std::vector<int> m_swept;          ///< the nodes that the last sweep was about
  std::vector<int> m_place_of_node;  ///< in m_swept; negative: not swept
};

/// The parameter `motion_budgets` (on or off) of the backends that can keep them.
ParameterSpec motion_budgets_parameter(bool on_by_default);
bool has_motion_budgets(const Parameters& parameters);

}  // namespace musclebench
