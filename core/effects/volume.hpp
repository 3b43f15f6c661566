#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// One constraint on the volume inside the closed surface (Mueller et al. 2007, section 4.4): C = V - pressure *
/// V_rest, with V = 1/6 sum p0 . (p1 x p2). Positions are relative to a point of the surface, so that no digits are
/// lost far from the origin.
std::unique_ptr<Effect> make_volume(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> volume_parameters();

}  // namespace musclebench
