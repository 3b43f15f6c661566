#pragma once

#include <memory>
#include <string>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// The `sdf` backend with `max_error_mm`: an adaptive field a bone (see `build_octree`) in place of a grid.
std::unique_ptr<CollisionBackend> make_octree_backend(const Parameters& parameters);

/// A bone's name as a part of a file's: letters and digits stay.
std::string bone_file_name(const std::string& bone_name);

}  // namespace musclebench
