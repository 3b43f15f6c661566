#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// Moves nodes slowly out of bones that they overlap at the start of a run, or out of a bone's margin. The displacement
/// in a substep is limited. The start position of the substep moves along, so the node gains no speed. Source: Macklin
/// et al. 2014, "Unified particle physics for real-time applications", section 4.4.
///
/// This works for every response, because only the displacement counts. Depth that such a node gains later is removed
/// at once, as for any other node. Not safe from several threads.
class StartOverlap {
 public:
  /// The input of a collision step. Spans over nodes have all nodes, in the world frame, in metres.
  struct Step {
    std::span<const Contact> contacts;  ///< found at p
    std::span<const RigidMotion> previous_bone_poses;
    std::span<const RigidMotion> bone_poses;
  };

  explicit StartOverlap(std::size_t nodes);

  /// Whether there may be such nodes. If not, skip the two calls below.
  [[nodiscard]] bool may_be_any() const { return m_is_first_step || m_are_any; }

  /// Call it before the response. In the first step it finds the nodes.
  void before_response(const Step& step, std::span<const Vec3> start, std::span<const Vec3> predicted);
  /// Call it after the response. It limits the displacement of the nodes to `most_m` and moves their `start` along.
  void after_response(const Step& step, double most_m, std::span<Vec3> start, std::span<Vec3> predicted);

 private:
  enum class State : std::uint8_t { began_outside, began_inside, listed };

  bool m_is_first_step = true;
  bool m_are_any = false;
  std::vector<State> m_state;  ///< by node
  // The nodes that are in contact.
  std::vector<int> m_nodes;
  std::vector<int> m_bones;    ///< the first bone that contains the node
  std::vector<Vec3> m_before;  ///< p before the response
};

}  // namespace musclebench
