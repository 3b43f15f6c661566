#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/scoped_timer.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// A bone without a complete structure, because no node is expected near it. Either nothing was built over it, or only
/// a part of a grid. The backend builds the rest when a node comes near after all.
struct PrunedBone {
  int bone = 0;
  double reach_m = 0;              ///< a node closer than this to the bone's box makes the backend build the structure
  double kept_share = 0;           ///< share of the grid's cells that were built at first, 0 to 1
  std::int64_t saved_queries = 0;  ///< queries that were skipped
  bool is_back = false;            ///< the rest was built, because a node came near
  Nanoseconds build_ns = 0;        ///< duration of that build
};

/// Detects the first node or triangle that comes near a pruned bone. Until then the bone has no contacts. A detection
/// tests each position once for all pruned bones together. A position that is not finite is near no bone. Positions are
/// in metres in the world frame. Not safe from several threads.
class ReachWatch {
 public:
  /// Watches a bone. `rest_box` is the box of its vertices in its rest frame. A node is near the bone if it is closer
  /// to the box than `reach_m`.
  void add(int bone, const Eigen::AlignedBox3d& rest_box, double reach_m);

  /// Whether any bone is watched.
  [[nodiscard]] bool is_active() const { return !m_watched.empty(); }
  /// Whether this bone is watched.
  [[nodiscard]] bool watches(int bone) const;
  /// All bones that were added, in ascending order.
  [[nodiscard]] std::span<const PrunedBone> bones() const { return m_bones; }

  /// Sets the poses of all bones.
  void move(std::span<const RigidMotion> poses);
  /// The watched bones that one of `nodes` is near, in ascending order. Valid until the next call.
  [[nodiscard]] std::span<const int> find_near(std::span<const Vec3> positions, std::span<const int> nodes);
  /// The same for triangles, for backends that collide surfaces. It compares boxes in the world frame.
  [[nodiscard]] std::span<const int> find_near(std::span<const Vec3> positions, std::span<const Triangle> triangles);

  /// Adds `nodes` to the saved queries of each watched bone.
  void count_saved_queries(std::size_t nodes);
  /// Stops watching the bone. Returns its entry.
  PrunedBone& bring_back(int bone);

 private:
  /// A box grown by its reach.
  struct Watched {
    std::size_t index;  ///< in m_bones
    Eigen::AlignedBox3d rest_box;
    RigidMotion pose;
    Eigen::AlignedBox3d world_box;  ///< box around the rest box in that pose
  };

  std::vector<PrunedBone> m_bones;
  std::vector<Watched> m_watched;  ///< the bones that are not back
  std::vector<int> m_near;         ///< scratch memory
};

}  // namespace musclebench
