#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/contact/bone.hpp"
#include "core/effects/no_passage/joined_sets.hpp"
#include "core/effects/no_passage/passage_paths.hpp"
#include "core/pbd/contact_stage.hpp"

namespace musclebench {

/// What still comes too close is joined to zones, which move as a whole: with the bone that they touch or that carries
/// a node of them, or by their mean displacement (rigid impact zones: Provot 1997, "Collision and self-collision
/// handling in cloth model dedicated to design garments"). Nothing in a zone moves against anything else in it, and
/// zones only grow. A zone of several bones follows the first of them; one with nodes that are bound and stand still
/// while their bone moves stands still, unless it touches a bone.
class PassageZones {
 public:
  /// `paths` outlives this.
  explicit PassageZones(const PassagePaths& paths) : m_paths(paths) {}

  /// A substep without zones. By node: where it starts, and where it is to end without them; world frame, m.
  void begin(std::span<const Vec3> from, std::span<const Vec3> to);

  /// Joins what the stencil's corners belong to. Whether that is news.
  bool join(const PassageStencil& stencil, const ContactStageInput& input);

  /// Moves the nodes of all zones, and marks them in `is_moved`, by node; the others are as they were given.
  void place(const ContactStageInput& input, std::span<const double> inverse_masses, std::span<Vec3> ends,
             std::span<char> is_moved);

  /// What the zone of a node has that moves as is prescribed: "femur and pelvis".
  [[nodiscard]] std::string prescribed_in_zone_of(int node, std::span<const Bone> bones);

 private:
  [[nodiscard]] int bone_item(std::size_t bone) const { return static_cast<int>(m_from.size() + bone); }
  [[nodiscard]] bool is_held(std::size_t node, const ContactStageInput& input) const;
  /// By zone: the bone that carries it, or one of these.
  static constexpr int nothing = -1;
  static constexpr int held = -2;
  [[nodiscard]] std::vector<int> carriers();

  const PassagePaths& m_paths;
  std::vector<Vec3> m_from;
  std::vector<Vec3> m_to;
  JoinedSets m_sets;            ///< of nodes, and behind them bones
  std::vector<char> m_is_in;    ///< by node
  std::vector<char> m_is_held;  ///< by node of a zone
};

}  // namespace musclebench
