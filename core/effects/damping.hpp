#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Velocities decay as exp(-rate t), whatever the time step.
std::unique_ptr<Effect> make_damping(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> damping_parameters();

}  // namespace musclebench
