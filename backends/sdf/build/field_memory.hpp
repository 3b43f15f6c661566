#pragma once

#include <span>

#include "backends/sdf/build/field_builder.hpp"

namespace musclebench {

/// Throws InputError (about the parameter that chose the grid) that says how much is needed, how much is there and
/// what fits, where the fields over `shapes`, laid out by `grid`, need more memory than there is.
void require_room(std::span<const GridShape> shapes, const GridSettings& grid);

}  // namespace musclebench
