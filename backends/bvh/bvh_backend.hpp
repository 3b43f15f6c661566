#pragma once

#include <memory>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// Exact: the closest point of every node by a tree of boxes over each bone's triangles in rest pose, signed robustly
/// (`SignedSurface`). Depth and normal are the true ones to rounding, wherever the bone stands.
std::unique_ptr<CollisionBackend> make_bvh_backend(const Parameters& parameters);
std::vector<ParameterSpec> bvh_parameters();

}  // namespace musclebench
