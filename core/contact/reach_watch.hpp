#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/scoped_timer.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// A bone over which nothing, or only a part of a grid, was built because no node was expected near the rest of it.
struct PrunedBone {
  int bone = 0;
  double reach_m = 0;     ///< where nothing was built: a node closer to the bone's box than this brings it back
  double kept_share = 0;  ///< of its grid's cells that were built at first
  std::int64_t saved_queries = 0;  ///< nodes that it was not asked about
  bool is_back = false;            ///< it was built, or completed, when a node came where none was expected
  Nanoseconds build_ns = 0;        ///< then
};

/// Notices the first node, or triangle, that comes near one of the pruned bones: until then none of them can be in
/// contact. Costs a look at each position a detection for all of them together; positions that are not numbers are
/// near nothing.
class ReachWatch {
 public:
  /// `rest_box`: of the bone's vertices, in its rest frame.
  void add(int bone, const Eigen::AlignedBox3d& rest_box, double reach_m);

  /// Whether it watches any bone, and whether that one.
  [[nodiscard]] bool is_active() const { return !m_watched.empty(); }
  [[nodiscard]] bool watches(int bone) const;
  /// Of all that were added, in ascending order.
  [[nodiscard]] std::span<const PrunedBone> bones() const { return m_bones; }

  /// `poses`: of all bones.
  void move(std::span<const RigidMotion> poses);
  /// The watched bones that one of `nodes` is near, ascending; valid until the next call.
  [[nodiscard]] std::span<const int> find_near(std::span<const Vec3> positions, std::span<const int> nodes);
  /// The same of triangles, for backends that collide surfaces: by their boxes in the world frame.
  [[nodiscard]] std::span<const int> find_near(std::span<const Vec3> positions, std::span<const Triangle> triangles);

  void count_saved_queries(std::size_t nodes);
  /// Watches it no longer.
  PrunedBone& bring_back(int bone);

 private:
  /// A box grown by its reach.
  struct Watched {
    std::size_t index;  ///< in m_bones
    Eigen::AlignedBox3d rest_box;
    RigidMotion pose;
    Eigen::AlignedBox3d world_box;  ///< of the rest box in that pose
  };

  std::vector<PrunedBone> m_bones;
  std::vector<Watched> m_watched;  ///< those that are not back
  std::vector<int> m_near;         ///< scratch memory
};

}  // namespace musclebench
