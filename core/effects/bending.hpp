#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Keeps the dihedral angle between neighbouring triangles (AngleConstraints): folding and unfolding are both resisted.
std::unique_ptr<Effect> make_bending(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> bending_parameters();

}  // namespace musclebench
