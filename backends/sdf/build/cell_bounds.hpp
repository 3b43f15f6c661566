#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "backends/sdf/grid/cubic_cell.hpp"

namespace musclebench {

/// Eight cells side by side.
struct CellBounds {
  static constexpr std::size_t width = 8;

  // Of the Bernstein coefficients, to the bit.
  alignas(64) std::array<double, width> lowest;
  alignas(64) std::array<double, width> highest;
  /// `CubicCell::lipschitz_bound` is not more, but for rounding.
  alignas(64) std::array<double, width> lipschitz_bound;
};

/// Bounds of up to eight cells (at least one) with edges of this size.
void bound_cells(std::span<const CubicCell> cells, const Vec3& cell_size_m, CellBounds& bounds);

}  // namespace musclebench
