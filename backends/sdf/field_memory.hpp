#pragma once

#include <vector>

#include "backends/sdf/field_builder.hpp"

namespace musclebench {

/// Throws InputError (place: the parameter that chose the grid) that says how much is needed, how much is there and
/// what fits, where the fields over these grids, laid out by `grid`, need more memory than there is.
void require_room(const std::vector<GridShape>& shapes, const GridSettings& grid, const FieldSettings& settings);

}  // namespace musclebench
