#pragma once

#include "backends/sdf/grid/field_block.hpp"

namespace musclebench {

/// Value and gradient of cubic cells (see CubicCell) at the points of a block, all of which lie in the field.
/// Arithmetic is in double precision, each operation rounded by itself and in the same order everywhere:
/// the same bits on any machine, whatever else is in the block.
void evaluate_block(const FieldView& field, FieldBlock& block);

}  // namespace musclebench
