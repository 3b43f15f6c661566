#pragma once

#include "backends/sdf/grid/cubic_field.hpp"

namespace musclebench {

/// Marks the cells where the field may be negative, and computes `lipschitz_bound`
/// (reports/performance/field_bounds.md). The same bits for any number of threads.
void find_cell_signs(CubicField& field, int threads);

}  // namespace musclebench
