#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"
#include "core/mesh/retinaculum.hpp"

namespace musclebench {

/// The middle of a tendon stays within the clearance of the axis of its ring. The middle is the mean of the nodes that
/// are nearer than w = half_width_m to the ring's plane, each by its area at rest and by 1 - |z| / w. A correction
/// moves nodes by the same weight, so that it does not flatten the tendon. A hard one-sided constraint without
/// friction; the bone bears the push.
std::unique_ptr<Effect> make_retinaculum(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> retinaculum_parameters();

}  // namespace musclebench
