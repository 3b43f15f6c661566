#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "backends/sdf/compact_record.hpp"

namespace musclebench {

/// How a field's values are kept.
enum class FieldPrecision : std::uint8_t {
  compact = 2,           ///< CompactRecord
  single_precision = 4,  ///< bytes of a value
  double_precision = 8,
};

/// Where a cell's values stand, and the place in its unit cube that is asked about.
struct CellQuery {
  /// The runs of the cell's edges along x at (y, z): place 2 y + z. Each is a grid vertex's record and the five first
  /// values of the next (see GridShape), or two CompactRecords.
  std::array<const void*, 4> run;
  std::array<double, 3> at;
};

/// The field and its derivatives along the axes of the unit cell.
struct CellAnswer {
  double value;
  std::array<double, 3> gradient;
};

/// Value and gradient of cubic cells (see CubicCell) in one pass, by the SIMD of the machine. Arithmetic is in double
/// precision, each operation rounded by itself and in the same order everywhere: the same bits on any machine.
/// `steps` matters for compact fields only.
void evaluate_cells(FieldPrecision precision, const CompactSteps& steps, std::span<const CellQuery> queries,
                    std::span<CellAnswer> answers);

}  // namespace musclebench
