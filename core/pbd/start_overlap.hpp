#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// Nodes that overlap bones, or the skin of a margin, before anything moves. A response lays them out of it as far as
/// it would, but by no more than a limit a substep, and moves where the substep began with them, so that they take up
/// no speed (Macklin et al. 2014, "Unified particle physics for real-time applications", section 4.4). It is the same
/// for every response: what counts is where it moved. What such a node comes in by later is undone whole, as of any
/// node; a backend that sees it in one step and not in the next must not throw it.
class StartOverlap {
 public:
  /// Input of a collision step, all nodes, world frame, m.
  struct Step {
    std::span<const Contact> contacts;  ///< found at p
    std::span<const RigidMotion> previous_bone_poses;
    std::span<const RigidMotion> bone_poses;
  };

  explicit StartOverlap(std::size_t nodes);

  /// Whether there may be any: nothing else costs any time afterwards.
  [[nodiscard]] bool may_be_any() const { return m_is_first_step || m_are_any; }

  /// Before the response. In the first step of all it finds the nodes.
  void before_response(const Step& step, std::span<const Vec3> start, std::span<const Vec3> predicted);
  /// After it: limits how far the nodes have left, and moves their `start` along. `most_m`: in this substep.
  void after_response(const Step& step, double most_m, std::span<Vec3> start, std::span<Vec3> predicted);

 private:
  enum class State : std::uint8_t { began_outside, began_inside, listed };

  bool m_is_first_step = true;
  bool m_are_any = false;
  std::vector<State> m_state;  ///< by node
  // Of those that are in contact.
  std::vector<int> m_nodes;
  std::vector<int> m_bones;    ///< of each the first bone that it is in
  std::vector<Vec3> m_before;  ///< of each p before the response
};

}  // namespace musclebench
