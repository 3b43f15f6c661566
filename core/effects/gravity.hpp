#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Constant acceleration: v += dt g for every free node, before positions are predicted (external forces of Mueller et
/// al. 2007, "Position based dynamics", section 3.1).
std::unique_ptr<Effect> make_gravity(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> gravity_parameters();

}  // namespace musclebench
