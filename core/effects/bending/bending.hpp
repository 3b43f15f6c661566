#pragma once

#include <memory>
#include <vector>

#include "core/constraints/angle_constraints.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Keeps the dihedral angle between neighbouring triangles (AngleConstraints): folding and unfolding are both resisted.
/// A pair all of whose nodes bones carry has no constraint.
EffectEntry bending_entry();

/// In the order of `surface_edges`.
std::vector<AngleConstraint> bending_constraints(const EffectInput& input, const Parameters& parameters);

}  // namespace musclebench
