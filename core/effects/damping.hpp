#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Velocities decay as exp(-rate t), whatever the time step: the exact solution of dv/dt = -rate v over a substep
/// (viscous drag: Witkin 1997, "Particle system dynamics"), where Mueller et al. 2007 ("Position based dynamics",
/// section 3.1) damp velocities.
std::unique_ptr<Effect> make_damping(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> damping_parameters();

}  // namespace musclebench
