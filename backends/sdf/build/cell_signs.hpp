#pragma once

#include "backends/sdf/grid/cubic_field.hpp"

namespace musclebench {

/// Where interpolation makes a filled field not positive on the border of its domain, makes the edges there straight:
/// all vertices of the border are outside the bone.
void keep_border_positive(CubicField& field);

/// Marks the cells where the field may be negative, and finds the facts `lipschitz_bound` and `sign_error_distance_m`.
/// The values at grid vertices are exact distances. The same bits for any number of threads. What these facts prove is
/// in reports/performance/field_bounds.md.
void find_cell_signs(CubicField& field, int threads);

}  // namespace musclebench
