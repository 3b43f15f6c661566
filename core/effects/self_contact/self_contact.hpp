#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Keeps a muscle from folding through itself: a node and a triangle of the same muscle stay a thickness apart, on the
/// side on which they were when the substep began (proximity constraints: Bridson, Fedkiw and Anderson 2002, "Robust
/// treatment of collisions, contact and friction for cloth animation"). Both sides give way by inverse mass
/// (ContactRowSolver), so that no momentum changes; depth that was there when the substep began gives no velocity.
///
/// What is closer than four times the thickness at rest, such as triangles around a node or the two sides of a thin
/// rim, is left out for good. The distance is exact, and a node is queried only once its clearance is used up
/// (MovingClearances). Edges that cross between nodes that are all apart by the thickness are not seen, nor is what
/// moves by more than the thickness in one substep.
EffectEntry self_contact_entry();

/// What is closer at rest, in thicknesses, is left out for good.
inline constexpr double self_contact_rest_factor = 4;

}  // namespace musclebench
