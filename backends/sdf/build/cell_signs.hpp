#pragma once

#include "backends/sdf/grid/cubic_field.hpp"

namespace musclebench {

/// Keeps a filled field positive on the border of its domain, where all vertices are outside the bone: edges on which
/// cubic interpolation is not positive are made linear.
void keep_border_positive(CubicField& field);

/// Of a filled field over a part of its domain, before that: whether no edge of the part's outermost cells can become
/// linear, so that in all other cells the part becomes what the whole field is. Always true for a whole field.
bool has_clear_rim(const CubicField& field);

/// Marks the cells where the field may be negative, and computes `lipschitz_bound` and `sign_error_distance_m`
/// (reports/performance/field_bounds.md). The values at grid vertices are exact distances. The same bits for any number
/// of threads.
void find_cell_signs(CubicField& field, int threads);

}  // namespace musclebench
