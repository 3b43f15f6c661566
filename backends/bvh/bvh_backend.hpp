#pragma once

#include <memory>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// Exact: the closest point of every node by a tree of boxes over each bone's triangles in rest pose, signed robustly
/// (`SignedSurface`). Depth and normal are the true ones to rounding, wherever the bone stands.
std::unique_ptr<CollisionBackend> make_bvh_backend(const Parameters& parameters);
BackendEntry bvh_entry();

}  // namespace musclebench
