#include "backends/voxel/cell_clearances.hpp"

#include <array>
#include <cmath>

namespace musclebench {

namespace {

constexpr double reach_of_diagonal = 1.0 / 8;
constexpr std::uint8_t largest_code = 255;
constexpr float reach_in_units = 255.0F * 255.0F;
/// Covers the rounding of single precision.
constexpr float rounded_down = 1 - 1e-5F;

/// Rows of cells of which each next one lies one cell farther along an axis.
struct Rows {
  std::uint8_t* first;
  std::array<std::size_t, 2> count;   ///< of a row's cells, of rows
  std::array<std::size_t, 2> stride;  ///< from cell to cell, from row to row

  [[nodiscard]] std::uint8_t& code(Eigen::Index cell, Eigen::Index row) const {
    return first[static_cast<std::size_t>(cell) * stride[0] + static_cast<std::size_t>(row) * stride[1]];
  }
};

/// Squares of distances in units, a column a row.
struct Squares {
  Eigen::ArrayXXf before, after;
};

/// One axis of a Euclidean distance transform (Saito and Toriwaki 1994): the least, over all rows, of what that row has
/// and what lies between. From the middle of a cell it is half a cell less far to another cell than to its middle.
void add_distances_between(const Rows& rows, double cell_size_in_units, Squares& squares) {
  const auto cells = static_cast<Eigen::Index>(rows.count[0]);
  const auto count = static_cast<Eigen::Index>(rows.count[1]);
  squares.before.resize(cells, count);
  for (Eigen::Index row = 0; row < count; ++row) {
    for (Eigen::Index cell = 0; cell < cells; ++cell) {
      const auto code = static_cast<float>(rows.code(cell, row));
      squares.before(cell, row) = code * code * (code * code);
    }
  }
  squares.after = squares.before;
  for (Eigen::Index away = 1; away < count; ++away) {
    const auto between = static_cast<float>((static_cast<double>(away) - 0.5) * cell_size_in_units);
    if (!(between < reach_in_units)) break;
    const Eigen::Index pairs = count - away;
    const float square = between * between;
    const auto lower = squares.after.leftCols(pairs), upper = squares.after.rightCols(pairs);
    squares.after.leftCols(pairs) = lower.min((squares.before.rightCols(pairs) + square) * rounded_down);
    squares.after.rightCols(pairs) = upper.min((squares.before.leftCols(pairs) + square) * rounded_down);
  }
  for (Eigen::Index row = 0; row < count; ++row) {
    for (Eigen::Index cell = 0; cell < cells; ++cell) {
      const float square = squares.after(cell, row);
      if (square < squares.before(cell, row)) {
        rows.code(cell, row) = static_cast<std::uint8_t>(std::sqrt(std::sqrt(square)));
      }
    }
  }
}

}  // namespace

CellClearances::CellClearances(const GridIndex& cells, const Vec3& cell_size_m, double diagonal_m,
                               const std::vector<std::uint64_t>& set_cells)
    : m_unit_m(reach_of_diagonal * diagonal_m / reach_in_units), m_codes(cells.size()) {
  for (std::size_t cell = 0; cell < m_codes.size(); ++cell) {
    m_codes[cell] = ((set_cells[cell / 64] >> (cell % 64)) & 1U) != 0 ? 0 : largest_code;
  }
  const auto [nx, ny, nz] = cells.count;
  const Vec3 size_in_units = cell_size_m / m_unit_m;
  Squares squares;
  for (std::size_t z = 0; z < nz; ++z) {
    std::uint8_t* const plane = m_codes.data() + z * nx * ny;
    add_distances_between({plane, {ny, nx}, {nx, 1}}, size_in_units.x(), squares);
    add_distances_between({plane, {nx, ny}, {1, nx}}, size_in_units.y(), squares);
  }
  for (std::size_t y = 0; y < ny; ++y) {
    add_distances_between({m_codes.data() + y * nx, {nx, nz}, {1, nx * ny}}, size_in_units.z(), squares);
  }
}

}  // namespace musclebench
