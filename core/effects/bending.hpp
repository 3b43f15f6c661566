#pragma once

#include <memory>
#include <vector>

#include "core/constraints/angle_constraints.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Keeps the dihedral angle between neighbouring triangles (AngleConstraints): folding and unfolding are both resisted.
/// A pair all of whose nodes bones carry has no constraint.
std::unique_ptr<Effect> make_bending(const EffectInput& input, const Parameters& parameters);
/// In the order of `surface_edges`.
std::vector<AngleConstraint> bending_constraints(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> bending_parameters();

}  // namespace musclebench
