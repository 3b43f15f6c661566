#pragma once

#include <string>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/build/octree_builder.hpp"
#include "core/base/parameters.hpp"

namespace musclebench {

// Parameters of the `sdf` backend as settings of the field builders.

GridSettings grid_settings(const Parameters& parameters);

/// Whether cells of several sizes are wanted: `max_error_mm` is positive. Throws InputError for a parameter that
/// another one makes meaningless: those of a grid beside `max_error_mm`, those of building beside `discregrid`, and
/// `cells` beside `cell_size_m`.
bool wants_octree(const Parameters& parameters);
OctreeSettings octree_settings(const Parameters& parameters);

/// A bone's name as a part of a file's: all that a scene lets it have stays (letters, digits, `_`, `-`, `.`), so that
/// no two bones of a scene share a file.
std::string bone_file_name(const std::string& bone_name);

/// The margin as a part of a structure's file name; empty for the usual one.
std::string margin_file_name(double margin);

}  // namespace musclebench
