#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Keeps nodes from passing through a bone: a node that would end a step on its far side is put back to where it
/// entered. Works after the response, whatever backend and response there are, on the exact surface. A node is tested
/// only where its path may have met the surface (ClearanceCache).
///
/// Rule `crossing` follows each node's path in the bone's moving frame, from step to step (continuous collision
/// detection of a point and a moving triangle: Provot 1997, "Collision and self-collision handling in cloth model
/// dedicated to design garments"; here against a rigid surface, so that a path is a line). A path that enters the
/// surface and leaves it where the surface has an opposed normal (outward normals n_in . n_out < 0) is cut where it
/// entered. While a node is inside, the point of the surface closest to it is tracked from where it entered; the node
/// may neither leave through nor come closer to a surface with an opposed normal. Rule `angle` is the paper's (section
/// VI-A): where the directions to the surface at the start and at the end of a step differ by more than `angle_deg`,
/// the node is put to where its path meets the surface.
///
/// The Referee's count of tunnelled nodes takes a path as straight from frame to frame (TunnellingTracker): it may
/// count a node that went around an edge in several substeps, which is no fault here. Through a hole of an open surface
/// nodes pass unseen: there is nothing to cross.
std::unique_ptr<ContactStage> make_tunnelling_guard(const StageInput& input, const Parameters& parameters);
std::vector<ParameterSpec> tunnelling_guard_parameters();

}  // namespace musclebench
