#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

/// Follows nodes from frame to frame and counts those that tunnelled: entered a bone through one face and left it
/// through one that faces the other way, within one frame or over many.
///
/// A node's path is taken as straight between two frames, in the bone's rest frame. Crossings of this segment with the
/// surface are exact. Entry and exit are opposed where their outward normals n make n_in . n_out < opposed_cosine: a
/// plate, a sphere near its middle. A node that dips in and comes out on the same side, or whose path cuts a convex
/// corner of a right angle or more, did not tunnel. Neither did one that was never deeper than `grazing_depth` times
/// the bone's diagonal: it slid around a sharp edge and cut it by a little. Depth on the path is sampled where a frame
/// ends and in the middle between that and entry or exit, so passing a plate shows half of its thickness: plates
/// thinner than twice the grazing depth are not seen. A node that tunnels once more through the same bone is back and
/// no longer counts. A node inside when it is seen first entered where the surface is closest.
class TunnellingTracker {
 public:
  static constexpr double opposed_cosine = -0.1;
  static constexpr double grazing_depth = 2e-4;

  TunnellingTracker(int bones, int nodes);

  /// Takes the next frame. `truth`: the result of the last `referee.judge`, for these poses, positions (world frame)
  /// and `nodes` (ascending). A node at a position that is not finite keeps its state. Returns `tunnelled_nodes()`.
  int update(const Referee& referee, std::span<const RigidMotion> poses, std::span<const Vec3> positions,
             std::span<const int> nodes, std::span<const Contact> truth);

  /// Nodes on the wrong side of some bone.
  [[nodiscard]] int tunnelled_nodes() const;
  [[nodiscard]] bool tunnelled(int node) const;

  /// Work of the last call of `update`, in the unit of RefereeTree: linear in the number of nodes.
  [[nodiscard]] long last_work() const { return m_work; }

  [[nodiscard]] std::size_t bytes() const;

 private:
  /// State of one node relative to one bone.
  struct NodeState {
    Vec3 point_m = Vec3::Zero();       ///< position in the last frame, relative to the tree's centre
    Vec3 entry_normal = Vec3::Zero();  ///< rest frame; where it is inside
    double deepest_m = 0;              ///< since it entered
    bool seen = false;
    bool inside = false;
    bool tunnelled = false;

    void enter(const Vec3& normal);
    void leave(const Vec3& normal, double grazing_m);
    /// Samples the depth at `inner_point`, relative to the tree's centre, which is inside.
    void sample_depth(const RefereeTree& tree, const Vec3& inner_point, long& work);
  };

  void follow_crossings(const RefereeTree& tree, const Vec3& point, NodeState& state);

  std::vector<std::vector<NodeState>> m_states;  // by bone, by node
  long m_work = 0;
  std::vector<SurfaceCrossing> m_crossings;  // scratch memory
};

}  // namespace musclebench
