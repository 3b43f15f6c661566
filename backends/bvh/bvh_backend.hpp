#pragma once

#include <memory>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// Makes a backend with exact signed distances. An 8-wide triangle BVH over each bone in rest pose finds the closest
/// point of a node, and SignedSurface its side. Depth and normal are exact up to rounding, at any pose of the bone.
/// `parameters` must be made from `bvh_entry().parameters`.
std::unique_ptr<CollisionBackend> make_bvh_backend(const Parameters& parameters);
/// The backend's row in the table of backends.
BackendEntry bvh_entry();

}  // namespace musclebench
