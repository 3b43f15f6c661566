#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "backends/sdf/grid/grid_shape.hpp"
#include "core/base/grid_index.hpp"

namespace musclebench {

/// The cells of a grid that have coefficients: those that may hold a point inside the bone, or outside it and within
/// `width_m` of its surface. The others are outside the bone, at least as far from it as the bound of their block.
///
/// Only grid vertices of kept cells have a record; they follow each other as in the full grid. A record is found by a
/// bit and by counting the bits before it, so that the whole index takes 3 bits a cell.
class NarrowBand {
 public:
  static constexpr std::size_t block_edge = 4;  ///< cells

  NarrowBand() = default;
  NarrowBand(const GridShape& shape, double width_m);

  [[nodiscard]] double width_m() const { return m_width_m; }
  [[nodiscard]] const GridIndex& blocks() const { return m_blocks; }
  [[nodiscard]] std::size_t record_count() const { return m_record_count; }
  [[nodiscard]] std::size_t bytes() const {
    return (m_cells.size() + m_vertices.size()) * sizeof(std::uint64_t) + m_before.size() * sizeof(std::uint32_t) +
           m_far_m.size() * sizeof(float);
  }

  [[nodiscard]] bool keeps(std::size_t cell) const { return is_set(m_cells, cell); }
  [[nodiscard]] bool has_record(std::size_t vertex) const { return is_set(m_vertices, vertex); }
  /// Of a vertex that has one.
  [[nodiscard]] std::size_t record(std::size_t vertex) const {
    const std::uint64_t below = m_vertices[vertex / 64] & ((std::uint64_t{1} << (vertex % 64)) - 1);
    return m_before[vertex / 64] + static_cast<std::size_t>(std::popcount(below));
  }

  /// Lower bound of the distance from the surface for all points of a cell that is not kept; all are outside.
  [[nodiscard]] float far_m(std::size_t i, std::size_t j, std::size_t k) const { return m_far_m[block(i, j, k)]; }

  // To choose the cells, and for files.
  void keep(std::size_t cell) { m_cells[cell / 64] |= std::uint64_t{1} << (cell % 64); }
  void set_far_m(std::size_t i, std::size_t j, std::size_t k, double bound_m);
  /// To be called once all cells are chosen.
  void index_records(const GridShape& shape);
  [[nodiscard]] std::vector<std::uint64_t>& cell_bits() { return m_cells; }
  [[nodiscard]] const std::vector<std::uint64_t>& cell_bits() const { return m_cells; }
  [[nodiscard]] std::vector<float>& far_bounds_m() { return m_far_m; }
  [[nodiscard]] const std::vector<float>& far_bounds_m() const { return m_far_m; }

 private:
  [[nodiscard]] static bool is_set(const std::vector<std::uint64_t>& bits, std::size_t bit) {
    return ((bits[bit / 64] >> (bit % 64)) & 1U) != 0;
  }
  [[nodiscard]] std::size_t block(std::size_t i, std::size_t j, std::size_t k) const {
    return m_blocks.index(i / block_edge, j / block_edge, k / block_edge);
  }

  double m_width_m = 0;
  GridIndex m_blocks;
  std::size_t m_record_count = 0;
  std::vector<std::uint64_t> m_cells;     ///< one bit a cell
  std::vector<std::uint64_t> m_vertices;  ///< one bit a grid vertex
  std::vector<std::uint32_t> m_before;    ///< records before each word of `m_vertices`
  std::vector<float> m_far_m;             ///< a block of cells
};

}  // namespace musclebench
