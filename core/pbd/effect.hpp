#pragma once

#include <span>
#include <string_view>

#include "core/mesh/rigid_motion.hpp"
#include "core/pbd/node_rows.hpp"
#include "core/pbd/team.hpp"

namespace musclebench {

/// What effects may depend on in a substep.
struct SubstepInput {
  double time_step_s = 0;
  std::span<const RigidMotion> bone_poses;
  double time_s = 0;  ///< at the end of the substep, from the start of the run
};

/// One physical effect of a scene. It exists only in scenes that name it.
class Effect {
 public:
  Effect() = default;
  Effect(const Effect&) = delete;
  Effect& operator=(const Effect&) = delete;
  virtual ~Effect() = default;

  /// The name in scene files and in the columns of the profile.
  [[nodiscard]] virtual std::string_view name() const = 0;

  // Every thread of `team` makes these calls, and does its share. The result is the same to the bit for any team.

  /// Called once a substep, before the prediction: external forces change `velocities`, a row each of `rows`.
  virtual void apply_force(const NodeRows& /*rows*/, std::span<NodeRow> /*velocities*/, const SubstepInput& /*input*/,
                           const Team& /*team*/) {}

  /// Called once a solver iteration: constraints are projected, that is, correct the predicted positions. The caller
  /// waits for the team before and afterwards.
  virtual void project(NodeRows& /*rows*/, const SubstepInput& /*input*/, const Team& /*team*/) {}
};

}  // namespace musclebench
