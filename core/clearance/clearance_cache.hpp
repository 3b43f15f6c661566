#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// Safe spheres of all pairs of a bone and a node, by which most nodes are known to be free without a query.
///
/// A node that was found at distance d from a bone stores a sphere of radius d about that location, fixed in the bone's
/// rest frame. While the relative motion of node and bone keeps the node inside its sphere, the node is free; when it
/// has left the sphere, the entry is expired and the backend has to query the node again. The cost of a detection then
/// grows with the motion of a step instead of with the number of nodes. The contacts stay the same to the bit, because
/// every radius is shrunk by all rounding errors of the test (reports/performance/clearance_cache.md has the bounds).
///
/// Spheres are kept in single precision relative to the middle of each bone. All bones are swept in one pass, since
/// converting the positions to single precision costs as much as testing them against one bone.
class ClearanceCache {
 public:
  /// Empties the cache. Of `bones` only the middles are copied; `nodes` is the number of positions.
  void reset(std::span<const Bone> bones, std::size_t nodes);
  /// After `reset`: keeps nothing of that bone and has no expired nodes for it, until it is taken up.
  void leave_out(int bone);
  void take_up(int bone);

  /// Finds those of `nodes` (ascending indices) that have left their safe spheres or have none. `positions` (of all
  /// nodes) are in the world frame, in metres; a position that is not finite counts as expired. `poses`: of all bones.
  void collect_expired(std::span<const RigidMotion> poses, std::span<const Vec3> positions, std::span<const int> nodes);

  /// Whether so many nodes are swept together; fewer are tested one by one, which takes longer a node.
  [[nodiscard]] bool sweeps(std::size_t nodes) const { return nodes > 0 && nodes >= m_nodes / sweep_fraction; }

  /// The nodes that the last `collect_expired` found for `bone`, ascending. Valid until the next call.
  [[nodiscard]] std::span<const int> expired(int bone) const {
    const SafeSpheres& spheres = m_bones[static_cast<std::size_t>(bone)];
    return std::span(spheres.expired).first(spheres.expired_count);
  }

  /// Stores that `node` is free of `bone` wherever it is closer than `clearance_m` (metres) to `rest_point` (in the
  /// bone's rest frame). A clearance that is not positive removes the entry. Different nodes may be stored by several
  /// threads at once.
  void store(int bone, int node, const Vec3& rest_point, double clearance_m);

  /// Distance in metres of `rest_point` (in the bone's rest frame) from the node's safe sphere, rounded up; negative
  /// inside the sphere, infinite without one. If the bone's surface is farther from `rest_point` than this, the empty
  /// sphere about that point overlaps the safe sphere, so that the point is free, too.
  [[nodiscard]] double distance_outside_m(int bone, int node, const Vec3& rest_point) const;

  /// Radius of the node's safe sphere in metres; 0 without one.
  [[nodiscard]] double radius_m(int bone, int node) const {
    return m_bones[static_cast<std::size_t>(bone)].of(node).radius_m;
  }

  /// The number of positions given to `reset`.
  [[nodiscard]] std::size_t nodes() const { return m_nodes; }
  [[nodiscard]] std::size_t bytes() const;

  /// The safe spheres of eight nodes as a structure of arrays: a sweep reads one stream, and the sphere of a single
  /// node lies in two cache lines.
  struct alignas(64) SafeSphereBlock {
    static constexpr std::size_t width = 8;
    std::array<float, width> x{}, y{}, z{}, radius_m{};
  };

  /// Input and output of a sweep for one bone.
  struct BoneSweep {
    const SafeSphereBlock* spheres = nullptr;
    std::array<std::array<float, 3>, 3> rotation{};  ///< world directions to the bone's rest frame
    std::array<float, 3> offset{};                   ///< from the bone's middle to the sweep's origin, rest frame
    float slack = 0;                                 ///< rounding error that the offset adds
    int* expired = nullptr;
    std::size_t count = 0;  ///< of expired nodes
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

/// The parameter `clearance_cache` (on, the default, or off) of the backends that can keep one.
ParameterSpec clearance_cache_parameter();
bool uses_clearance_cache(const Parameters& parameters);

}  // namespace musclebench
