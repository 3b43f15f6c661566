#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/grid_index.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Lower bounds of the distance from the middle of each cell of a grid to the nearest set cell, a byte each. Its step
/// grows with the distance, so that it is fine near set cells and reaches far. Distances end at an eighth of the grid's
/// diagonal: what is farther away is told as that eighth.
class CellClearances {
 public:
  CellClearances() = default;
  /// `set_cells`: a bit a cell. `diagonal_m` is the grid's, of which `cells` may be a part.
  CellClearances(const GridIndex& cells, const Vec3& cell_size_m, double diagonal_m,
                 const std::vector<std::uint64_t>& set_cells);

  [[nodiscard]] bool empty() const { return m_codes.empty(); }
  /// 0 for a set cell.
  [[nodiscard]] double distance_m(std::size_t cell) const {
    const int code = m_codes[cell];
    return m_unit_m * (code * code);
  }
  [[nodiscard]] std::size_t bytes() const { return m_codes.size(); }

 private:
  double m_unit_m = 0;
  std::vector<std::uint8_t> m_codes;  ///< the root of the distance in units, rounded down
};

}  // namespace musclebench
