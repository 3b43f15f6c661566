#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Keeps the dihedral angle between neighbouring triangles: C = angle - rest angle, signed, in (-pi, pi]; folding and
/// unfolding are both resisted. The gradients use the triangles' heights (Bridson et al. 2003; Tamstorf and Grinspun
/// 2013), which are regular for flat pairs; pairs with a degenerate triangle are skipped. With a compliance the
/// constraint is that of XPBD (Macklin et al. 2016).
std::unique_ptr<Effect> make_bending(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> bending_parameters();

}  // namespace musclebench
