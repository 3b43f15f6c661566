#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "backends/sdf/cell_map.hpp"
#include "backends/sdf/compact_record.hpp"
#include "backends/sdf/cubic_cell.hpp"
#include "backends/sdf/narrow_band.hpp"

namespace musclebench {

/// How a field's values are kept.
enum class FieldPrecision : std::uint8_t {
  compact = 2,           ///< CompactRecord
  single_precision = 4,  ///< bytes of a value
  double_precision = 8,
};

/// A field as its kernels read it. What it points to is the field's.
struct FieldView {
  FieldPrecision precision;
  const void* values;           ///< of the first grid vertex (see GridShape), or its CompactRecord
  const NarrowBand* band;       ///< none for a dense field
  std::array<double, 3> cells;  ///< along each axis
  std::array<double, 3> cells_per_m;
  CompactSteps steps;  ///< of a compact field
};

/// Points that are asked about together, side by side: where they are in a field, and what it says there.
struct FieldBlock {
  static constexpr std::size_t capacity = 128;
  static constexpr std::size_t most_lanes = 4;
  /// Vectors are written whole.
  template <typename Scalar>
  using Lanes = std::array<Scalar, capacity + most_lanes>;

  std::size_t count = 0;
  alignas(64) Lanes<double> x, y, z;  ///< in units of the field's cells
  alignas(64) Lanes<double> value_m;
  alignas(64) Lanes<double> slope_x, slope_y, slope_z;  ///< by metres along the field's axes
  alignas(64) Lanes<std::uint64_t> asker;               ///< ascending

  [[nodiscard]] Vec3 cells(std::size_t n) const { return {x[n], y[n], z[n]}; }
};

/// Appends to `block` those of `nodes` (ascending indices into `positions`) that are in the field and in a cell whose
/// bit in `wanted` is set (all cells where it is null); `asker` is the place in `nodes`, plus `first`. Stops where the
/// block is full; returns how many of `nodes` were looked at. A position that is not a number is nowhere.
std::size_t place_nodes(const FieldView& field, const CellMap& map, const std::uint64_t* wanted,
                        std::span<const Vec3> positions, std::span<const int> nodes, std::size_t first,
                        FieldBlock& block);

/// Value and gradient of cubic cells (see CubicCell) at the points of a block, all of which lie in cells that the field
/// knows. Arithmetic is in double precision, each operation rounded by itself and in the same order everywhere: the
/// same bits on any machine, whoever else is in the block.
void evaluate_block(const FieldView& field, FieldBlock& block);

}  // namespace musclebench
