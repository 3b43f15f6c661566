#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Contact of the muscle's faces and edges with bones, not only of its nodes: a bone's ridge can cut through a triangle
/// whose corners are all outside. The deepest points of faces (FaceContactFinder) are kept out of the bone; a
/// correction is shared among the corners by their barycentric weights and inverse masses (ContactRowSolver; as the
/// impulses of Bridson, Fedkiw and Anderson 2002, "Robust treatment of collisions, contact and friction for cloth
/// animation"). A bone's vertex that pokes through a face is such a point.
///
/// Points are searched for every `interval` collision steps; in between the planes move with their bones, but for those
/// at sharp vertices, which are followed. Depth that was there when the substep began gives no velocity. The distance
/// is exact, whatever backend finds contacts of nodes, unless `StageInput::make_surface_queries` says who answers
/// (`--for faces`). Only triangles near a bone are queried (ClearanceCache). Searches start at a few points of a
/// triangle, and so may miss one between them where a bone is narrower than a fraction of the triangle.
std::unique_ptr<ContactStage> make_surface_contact(const StageInput& input, const Parameters& parameters);
std::vector<ParameterSpec> surface_contact_parameters();

}  // namespace musclebench
