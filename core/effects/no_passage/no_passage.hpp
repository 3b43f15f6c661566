#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Lets no node, edge or face of a muscle pass through a bone, another muscle or the muscle itself, at any speed: what
/// does not intersect when a substep begins does not intersect when it ends.
///
/// After everything else has moved the nodes, each pair of features whose paths come close is followed by additive
/// conservative advancement (`safe_share`), against a bone in the bone's frame. Pairs that would come too close become
/// rows of ContactRowSolver, with the normal that they have just before they touch, and the new paths are followed in
/// turn. What rows don't settle is joined to zones, which move as a whole: with the bone that they touch, or by their
/// mean displacement (rigid impact zones: Provot 1997, "Collision and self-collision handling in cloth model dedicated
/// to design garments"; Bridson, Fedkiw and Anderson 2002). Nothing in a zone moves against anything else in it, and
/// zones only grow, so that this ends.
///
/// What a step has to look at, `NearPairs` tells from the distances that earlier steps measured.
///
/// Left out, as no choice of positions can prevent them: faces of which a node is bound to the bone, and features that
/// only bones move. What intersects a collider as the run begins, or lies inside it, is left out until it is free of it
/// (`LeftOut`). Where bones close on a zone from two sides, it follows the first of them.
std::unique_ptr<ContactStage> make_no_passage(const StageInput& input, const Parameters& parameters);
std::vector<ParameterSpec> no_passage_parameters();

}  // namespace musclebench
