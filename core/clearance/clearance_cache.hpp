#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// A cache of safe spheres, one for each pair of bone and node. It shows for most nodes that they are free of a bone,
/// without a query.
///
/// If a query finds a node at distance d from a bone, the cache stores a sphere of radius d around it. The sphere is
/// fixed in the bone's rest frame. The node is free as long as it stays inside the sphere. After that the entry has
/// expired, and the backend must query the node again. The cost of a detection then grows with the motion of a step,
/// not with the number of nodes. The cache never changes a bit of the contacts: every radius is reduced by all rounding
/// errors of the test (reports/performance/clearance_cache.md has the bounds).
///
/// Spheres are stored in single precision relative to the middle of each bone. One pass tests all bones, because
/// converting the positions to single precision costs as much as testing one bone.
///
/// Only `store` and the const functions are safe from several threads.
class ClearanceCache {
 public:
  /// Empties the cache. It copies only the middles of `bones`. `nodes` is the number of positions.
  void reset(std::span<const Bone> bones, std::size_t nodes);
  /// Ignores a bone after `reset`: it has no entries and no expired nodes until `take_up`.
  void leave_out(int bone);
  /// Ends `leave_out` for a bone.
  void take_up(int bone);

  /// Finds those of `nodes` (ascending indices) that have left their safe sphere or have none. `positions` has all
  /// nodes, in the world frame, in metres. `poses` has all bones. A position that is not finite counts as expired.
  void collect_expired(std::span<const RigidMotion> poses, std::span<const Vec3> positions, std::span<const int> nodes);

  /// Whether so many nodes are swept together. Fewer nodes are tested one by one, which takes longer for each node.
  [[nodiscard]] bool sweeps(std::size_t nodes) const { return nodes > 0 && nodes >= m_nodes / sweep_fraction; }

  /// The nodes that the last `collect_expired` found for `bone`, ascending. Valid until its next call.
  [[nodiscard]] std::span<const int> expired(int bone) const {
    const SafeSpheres& spheres = m_bones[static_cast<std::size_t>(bone)];
    return std::span(spheres.expired).first(spheres.expired_count);
  }

  /// Stores a safe sphere of radius `clearance_m` (metres) around `rest_point` (in the bone's rest frame). A clearance
  /// that is not positive removes the entry. Several threads may store different nodes at once.
  void store(int bone, int node, const Vec3& rest_point, double clearance_m);

  /// The distance in metres from `rest_point` (in the bone's rest frame) to the node's safe sphere, rounded up. It is
  /// negative inside the sphere, and infinite without one. If the bone's surface is farther from `rest_point` than
  /// this, the point is free: its own empty sphere overlaps the safe sphere.
  [[nodiscard]] double distance_outside_m(int bone, int node, const Vec3& rest_point) const;

  /// Radius of the node's safe sphere in metres. 0 without one.
  [[nodiscard]] double radius_m(int bone, int node) const {
    return m_bones[static_cast<std::size_t>(bone)].of(node).radius_m;
  }

  /// The number of positions given to `reset`.
  [[nodiscard]] std::size_t nodes() const { return m_nodes; }
  /// Memory of the cache.
  [[nodiscard]] std::size_t bytes() const;

  /// The safe spheres of eight nodes as a structure of arrays. A sweep reads one stream, and the sphere of a single
  /// node is in two cache lines.
  struct alignas(64) SafeSphereBlock {
    static constexpr std::size_t width = 8;
    std::array<float, width> x{}, y{}, z{}, radius_m{};
  };

  /// The input and output of a sweep for one bone.
  struct BoneSweep {
    const SafeSphereBlock* spheres = nullptr;
    std::array<std::array<float, 3>, 3> rotation{};  ///< world directions to the bone's rest frame
    std::array<float, 3> offset{};                   ///< from the bone's middle to the sweep's origin, rest frame
    float slack = 0;                                 ///< additional rounding error from the offset
    int* expired = nullptr;
    std::size_t count = 0;  ///< number of expired nodes
  };

 private:
  /// Fewer nodes than this fraction of all are tested one by one: a sweep reads the spheres of all nodes.
  static constexpr std::size_t sweep_fraction = 4;

  struct SafeSphere {
    Vec3 centre_m;
    double radius_m;
  };

  /// The safe spheres of all nodes for one bone, in its rest frame relative to its middle.
  struct SafeSpheres {
    Vec3 middle_m;
    std::vector<SafeSphereBlock> blocks;
    std::vector<int> expired;  ///< one vector longer than needed: a compressed store writes whole vectors
    std::size_t expired_count = 0;

    [[nodiscard]] bool is_left_out() const { return blocks.empty(); }
    [[nodiscard]] SafeSphere of(int node) const;
  };

  void plan_sweep(std::span<const int> nodes);
  [[nodiscard]] Vec3 sweep_origin(std::span<const RigidMotion> poses) const;
  static void collect_one_by_one(const RigidMotion& pose, std::span<const Vec3> positions, std::span<const int> nodes,
                                 SafeSpheres& spheres);

  std::vector<SafeSpheres> m_bones;
  std::size_t m_nodes = 0;
  std::vector<int> m_queried;       ///< the nodes of the last sweep
  std::vector<int> m_is_queried;    ///< by node: -1 (all bits set) or 0
  std::vector<BoneSweep> m_sweeps;  ///< scratch memory
};

/// The parameter `clearance_cache` (on or off; on by default) of backends that support the cache.
ParameterSpec clearance_cache_parameter();
/// Whether that parameter is on.
bool uses_clearance_cache(const Parameters& parameters);

}  // namespace musclebench
