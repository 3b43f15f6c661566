#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Keeps the volume inside each muscle's closed surface (VolumeConstraints), or `pressure` times it, as the balloons of
/// Mueller et al. 2007 ("Position based dynamics", section 4.4).
EffectEntry volume_entry();

std::vector<ParameterSpec> volume_parameters();

}  // namespace musclebench
