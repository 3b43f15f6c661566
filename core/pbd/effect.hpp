#pragma once

#include <span>
#include <string_view>

#include "core/mesh/rigid_motion.hpp"
#include "core/pbd/particles.hpp"

namespace musclebench {

/// What effects may depend on in a substep.
struct SubstepInput {
  double time_step_s = 0;
  std::span<const RigidMotion> bone_poses;
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

  /// Called once a substep, before the prediction: external forces change velocities.
  virtual void apply_force(Particles& /*particles*/, const SubstepInput& /*input*/) {}

  /// Called once a solver iteration: constraints are projected, that is, correct the predicted positions.
  virtual void project(Particles& /*particles*/, const SubstepInput& /*input*/) {}
};

}  // namespace musclebench
