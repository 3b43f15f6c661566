#pragma once

#include <memory>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// The `sdf` backend with `max_error_mm`: an adaptive field a bone (see `build_octree`) in place of a grid. Throws
/// InputError where parameters of a grid are given.
std::unique_ptr<CollisionBackend> make_octree_backend(const Parameters& parameters);

}  // namespace musclebench
