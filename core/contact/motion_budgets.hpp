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
  /// Spends all budgets. Keeps nothing of `bones` but where they are; `nodes` is the number of positions.
  void reset(std::span<const Bone> bones, std::size_t nodes);

  /// The places in `nodes` of those that have left their balls about `bone`, or never had one, into `spent`, ascending.
  /// `positions` are in the world frame, in metres, and may be anything, also not finite (then spent).
  void collect_spent(int bone, const RigidMotion& pose, std::span<const Vec3> positions, std::span<const int> nodes,
                     std::vector<int>& spent) const;

  /// Promises that `node` is free of `bone` wherever it is nearer than `clearance_m` to `rest_point` (in the bone's
  /// rest frame). May be called for different nodes by several threads at once. A clearance that is not positive spends
  /// the budget.
  void grant(int bone, int node, const Vec3& rest_point, double clearance_m);

  [[nodiscard]] std::size_t bytes() const {
    return m_bones.capacity() * sizeof(BoneBalls) + m_ball_count * sizeof(Ball);
  }

  struct Ball {
    float x = 0, y = 0, z = 0;  ///< about the bone's middle, rest frame
    float radius_m = 0;
  };

 private:
  struct BoneBalls {
    Vec3 middle_m;  ///< rest frame
    std::vector<Ball> of_node;
  };

  std::vector<BoneBalls> m_bones;
  std::size_t m_ball_count = 0;
};

/// The parameter `motion_budgets` (on or off) of the backends that can keep them.
ParameterSpec motion_budgets_parameter(bool on_by_default);
bool has_motion_budgets(const Parameters& parameters);

}  // namespace musclebench
