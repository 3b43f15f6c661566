#pragma once

#include <memory>
#include <vector>

#include "core/constraints/length_constraints.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Distance constraint on every edge (Mueller et al. 2007, section 3.3): C = |p_b - p_a| - L. With fibres its stiffness
/// is scaled by (1 - |cos|)^exponent of the angle to the nearest fibre at rest, so that a muscle can shorten along its
/// fibres. With a compliance (XPBD, Macklin et al. 2016) the shape does not depend on time step and iterations; the
/// compliance is then divided by that factor instead, and with `per_area` by `relative_area`. An edge of length 0 has
/// no direction and is skipped. An edge between two nodes that bones carry has none.
EffectEntry edge_length_entry();

/// In the order of `surface_edges`.
std::vector<LengthConstraint> edge_length_constraints(const EffectInput& input, const Parameters& parameters);

}  // namespace musclebench
