#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Dihedral angle between neighbouring triangles kept at rest: C = angle - rest angle, signed, in (-pi, pi], both ways.
/// Gradients by the triangles' heights (Bridson et al. 2003; Tamstorf and Grinspun 2013), regular for flat pairs; a
/// degenerate triangle is skipped.
std::unique_ptr<Effect> make_bending(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> bending_parameters();

}  // namespace musclebench
