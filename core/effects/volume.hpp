#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// One constraint on the whole closed surface (Mueller et al. 2007, 4.4), C = V - pressure * V_rest, with
/// V = 1/6 sum p0 . (p1 x p2). Both are taken about a point of the surface, which keeps the digits far from the origin.
std::unique_ptr<Effect> make_volume(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> volume_parameters();

}  // namespace musclebench
