#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// A muscle contracts along its fibres by a course over time: from `start_s` the activation rises linearly to `level`
/// within `rise_s`, stays for `hold_s` and falls to 0 within `fall_s`. At activation a the fibres want to be
/// s = 1 - a * `shortening` times as long as at rest.
///
/// Every edge is a distance constraint with a compliance (XPBD), whose rest length is that of the edge in a muscle that
/// has shortened by s along the nearest fibre and become 1 / sqrt(s) times as thick, which keeps its volume; an edge
/// counts by the part of it along the fibre. Contraction by rest lengths along fibres is as in Romeo, Monteagudo,
/// Sanchez-Quiros, Garcia-Fernandez and Urena 2018, "Muscle simulation with extended position based dynamics". Without
/// fibres the effect has nothing to act on.
std::unique_ptr<Effect> make_activation(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> activation_parameters();

}  // namespace musclebench
