#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Contact of the muscle's faces and edges with bones, not only of its nodes: a bone's ridge can cut through a triangle
/// whose corners are all outside. Of each triangle near a bone the deepest point is found by projected descent on the
/// exact signed distance (Macklin, Erleben, Mueller, Chentanez, Jeschke and Corse 2020, "Local optimization for robust
/// signed distance field collision") and kept out of the tangent plane there; the correction is shared among the
/// corners by their barycentric weights and inverse masses. A bone's vertex that pokes through a face is such a point.
///
/// Points are searched for every `interval` collision steps; in between the planes move with their bones. Depth that
/// was there when the substep began gives no velocity. The distance is exact, whatever the backend: only triangles near
/// a bone are queried (ClearanceCache). Searches start at a triangle's middle and near its corners, and so may miss a
/// point between them where a bone is narrower than a fraction of the triangle.
std::unique_ptr<ContactStage> make_surface_contact(const StageInput& input, const Parameters& parameters);
std::vector<ParameterSpec> surface_contact_parameters();

}  // namespace musclebench
