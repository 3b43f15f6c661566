#pragma once

#include <memory>

#include "backends/sdf/bone_field.hpp"
#include "core/base/parameters.hpp"

namespace musclebench {

/// Adaptive fields (see `build_octree`): built, or loaded where `structures` names a folder.
std::unique_ptr<FieldSource> make_octree_field_source(const Parameters& parameters);

}  // namespace musclebench
