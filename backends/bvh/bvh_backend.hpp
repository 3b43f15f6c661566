#pragma once

#include <memory>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// Exact signed distances: the closest point of every node by an 8-wide triangle BVH over each bone in rest pose, its
/// side by SignedSurface. Depth and normal are exact to rounding at any pose of the bone.
std::unique_ptr<CollisionBackend> make_bvh_backend(const Parameters& parameters);
std::vector<ParameterSpec> bvh_parameters();

}  // namespace musclebench
