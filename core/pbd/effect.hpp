#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "core/mesh/rigid_motion.hpp"
#include "core/pbd/node_rows.hpp"
#include "core/pbd/team.hpp"

namespace musclebench {

/// The input of effects in a substep.
struct SubstepInput {
  double time_step_s = 0;
  std::span<const RigidMotion> bone_poses;  ///< by bone, from the rest frame to the world frame
  double time_s = 0;                        ///< at the end of the substep, from the start of the run
};

/// A physical effect of a scene: a force or constraints. Derive from it to add an effect to a Simulation.
class Effect {
 public:
  Effect() = default;
  Effect(const Effect&) = delete;
  Effect& operator=(const Effect&) = delete;
  virtual ~Effect() = default;

  /// The name of the effect in scene files, and of its column in frames.csv.
  [[nodiscard]] virtual std::string_view name() const = 0;

  // Every thread of `team` calls these functions at once and does its share. The bits of the result must not depend on
  // the size of the team.

  /// Whether the effect changes velocities and nothing else.
  [[nodiscard]] virtual bool is_force() const { return false; }

  /// Called once in each substep, before the prediction. Forces change `velocities` (m/s), which has a row for each of
  /// `rows`.
  virtual void apply_force(const NodeRows& /*rows*/, std::span<NodeRow> /*velocities*/, const SubstepInput& /*input*/,
                           const Team& /*team*/) {}

  /// Called once in each solver iteration. Constraints correct the predicted positions in `rows` (m). The caller waits
  /// for the team before and after the call.
  virtual void project(NodeRows& /*rows*/, const SubstepInput& /*input*/, const Team& /*team*/) {}

  // One thread calls these.

  /// Called before the first substep of each frame.
  virtual void begin_frame() {}
  /// Of an effect whose fibres pull: for each muscle the mean force along all fibres times the time since
  /// `begin_frame`, N s. Empty for all others.
  [[nodiscard]] virtual std::vector<double> fibre_impulses_n_s() const { return {}; }
};

}  // namespace musclebench
