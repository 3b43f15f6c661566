#pragma once

#include <memory>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// Exact signed distances: the closest point of every node by an 8-wide triangle BVH over each bone in rest pose, its
/// side by SignedSurface. Depth and normal are exact to rounding at any pose of the bone.
std::unique_ptr<CollisionBackend> make_bvh_backend(const Parameters& parameters);
BackendEntry bvh_entry();

}  // namespace musclebench
