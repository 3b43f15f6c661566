#pragma once

#include <memory>

#include "backends/sdf/bone_field.hpp"
#include "core/base/parameters.hpp"

namespace musclebench {

/// Fields over a regular grid of cells: built, or loaded where `structures` names a folder.
std::unique_ptr<FieldSource> make_grid_field_source(const Parameters& parameters);

/// Fields that someone else has built, in Discregrid's format, from the folder that `discregrid` names.
std::unique_ptr<FieldSource> make_discregrid_field_source(const Parameters& parameters);

}  // namespace musclebench
