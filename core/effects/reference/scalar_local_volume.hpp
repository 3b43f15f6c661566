#pragma once

#include <memory>

#include "core/effects/reference/scalar_effect.hpp"

namespace musclebench {

/// The effect `local_volume`: each region as a closed mesh of its own, whose cuts are fans about a vertex that is the
/// mean of others.
std::unique_ptr<ScalarEffect> make_scalar_local_volume(const EffectInput& input, const Parameters& parameters);

}  // namespace musclebench
