#pragma once

#include <array>
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
/// Balls are held in single precision about the middle of each bone. All bones are swept together, because bringing
/// the positions into single precision costs as much as asking a bone's balls; for a bone and a node it is less than
/// one bit of a voxel grid costs.
class ClearanceCache {
 public:
  /// Spends all budgets. Keeps nothing of `bones` but where they are; `nodes` is the number of positions.
  void reset(std::span<const Bone> bones, std::size_t nodes);

  /// Finds those of `nodes` (ascending) that have left their balls, or never had one. `positions` (of all nodes) are in
  /// the world frame, in metres, and may be anything, also not finite (then spent). `poses`: of all bones.
  void collect_spent(std::span<const RigidMotion> poses, std::span<const Vec3> positions, std::span<const int> nodes);

  /// The nodes that the last `collect_spent` found for `bone`, ascending. Valid until the next.
  [[nodiscard]] std::span<const int> spent(int bone) const {
    const Balls& balls = m_bones[static_cast<std::size_t>(bone)];
    return std::span(balls.spent).first(balls.spent_count);
  }

  /// Promises that `node` is free of `bone` wherever it is nearer than `clearance_m` to `rest_point` (in the bone's
  /// rest frame). May be called for different nodes by several threads at once. A clearance that is not positive leaves
  /// it without a budget.
  void grant(int bone, int node, const Vec3& rest_point, double clearance_m);

  /// How far `rest_point` (in the bone's rest frame) is outside the node's ball; infinite without a ball. A ball about
  /// that point that no surface reaches into and that is larger overlaps the node's: then it is as free.
  [[nodiscard]] double gap_m(int bone, int node, const Vec3& rest_point) const;

  /// Of the node's ball; 0 without one.
  [[nodiscard]] double radius_m(int bone, int node) const {
    return m_bones[static_cast<std::size_t>(bone)].of(node).radius_m;
  }

  /// That `reset` was told of.
  [[nodiscard]] std::size_t nodes() const { return m_nodes; }
  [[nodiscard]] std::size_t bytes() const;

  /// The balls of eight nodes: a sweep goes through memory in one way, and a single ball is in two cache lines.
  struct alignas(64) EightBalls {
    static constexpr std::size_t width = 8;
    std::array<float, width> x{}, y{}, z{}, radius_m{};
  };

  /// One bone's balls, where it stands, and what a sweep finds.
  struct SweptBone {
    const EightBalls* balls = nullptr;
    std::array<std::array<float, 3>, 3> rotation{};  ///< row i takes a direction of the world to the bone's axis i
    std::array<float, 3> offset{};                   ///< from the bone's middle to the sweep's, in the bone's axes
    float slack = 0;                                 ///< for the offset
    int* spent = nullptr;
    std::size_t count = 0;
  };

 private:
  struct Ball {
    Vec3 centre_m;
    double radius_m;
  };

  /// Of one bone, about its middle, in its rest frame.
  struct Balls {
    Vec3 middle_m;
    std::vector<EightBalls> eights;
    std::vector<int> spent;  ///< with room for a compressed vector, which is stored whole
    std::size_t spent_count = 0;

    [[nodiscard]] Ball of(int node) const;
  };

  void plan_sweep(std::span<const int> nodes);
  static void collect_one_by_one(const RigidMotion& pose, std::span<const Vec3> positions, std::span<const int> nodes,
                                 Balls& balls);

  std::vector<Balls> m_bones;
  std::size_t m_nodes = 0;
  std::vector<int> m_swept;         ///< the nodes that the last sweep was about
  std::vector<int> m_is_swept;      ///< by node: -1 or 0
  std::vector<SweptBone> m_sweeps;  ///< scratch memory
};

/// The parameter `clearance_cache` (on, the default, or off) of the backends that can keep one.
ParameterSpec clearance_cache_parameter();
bool uses_clearance_cache(const Parameters& parameters);

}  // namespace musclebench
