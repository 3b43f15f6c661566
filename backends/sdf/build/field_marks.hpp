#pragma once

#include "backends/sdf/grid/cubic_field.hpp"

namespace musclebench {

/// Where interpolation makes a filled field not positive on the border of its domain, makes the edges there straight:
/// all vertices of the border are outside the bone.
void keep_border_positive(CubicField& field);

/// Marks the cells where the field may be negative, and finds the facts `steepest` and `negative_reach_m`. The values
/// at grid vertices are exact distances. The same bits for any number of threads.
void mark_cells(CubicField& field, int threads);

}  // namespace musclebench
