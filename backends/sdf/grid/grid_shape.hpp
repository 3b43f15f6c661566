#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/grid_index.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A cell of a grid and a position in it, in [0, 1]^3.
struct CellPosition {
  std::size_t i, j, k;
  Vec3 at;
};

/// The regular grid of a cubic field: a box of cells, and the memory layout of the values at its nodes.
///
/// Every grid vertex owns a record of seven values: its own, and those of the two nodes on each edge that leaves it
/// upwards along y, z and x. Records follow each other along x; the last of a row lacks its two nodes along x. So each
/// offset is computed, and a cell reads four runs of twelve values. (The nodes that would lie beyond the last y or z
/// stay unused.)
struct GridShape {
  static constexpr std::size_t record_size = 7;
  /// Of the first of the two nodes on the edge that leaves a vertex along each axis, in its record.
  static constexpr std::array<std::size_t, 3> edge_offset{5, 1, 3};

  Vec3 lower_m = Vec3::Zero();      ///< corner of the domain
  Vec3 cell_size_m = Vec3::Ones();  ///< edges of a cell
  std::array<std::int32_t, 3> cells{1, 1, 1};

  [[nodiscard]] std::size_t count(std::size_t axis) const { return static_cast<std::size_t>(cells[axis]); }
  [[nodiscard]] Vec3 upper_m() const { return vertex(cells[0], cells[1], cells[2]); }
  [[nodiscard]] Vec3 vertex(int i, int j, int k) const { return lower_m + cell_size_m.cwiseProduct(Vec3(i, j, k)); }

  [[nodiscard]] GridIndex cell_grid() const { return {{count(0), count(1), count(2)}}; }
  [[nodiscard]] GridIndex vertex_grid() const { return {{count(0) + 1, count(1) + 1, count(2) + 1}}; }

  [[nodiscard]] std::size_t cell_count() const { return cell_grid().size(); }
  [[nodiscard]] std::size_t row_stride() const { return record_size * (count(0) + 1) - 2; }
  [[nodiscard]] std::size_t value_count() const { return row_stride() * (count(1) + 1) * (count(2) + 1); }
  /// Nodes of the grid: vertices and two on each edge.
  [[nodiscard]] std::size_t node_count() const {
    const std::size_t x = count(0), y = count(1), z = count(2);
    return (x + 1) * (y + 1) * (z + 1) + 2 * (x * (y + 1) * (z + 1) + (x + 1) * y * (z + 1) + (x + 1) * (y + 1) * z);
  }

  [[nodiscard]] std::size_t vertex_count() const { return vertex_grid().size(); }
  [[nodiscard]] std::size_t vertex_index(std::size_t i, std::size_t j, std::size_t k) const {
    return vertex_grid().index(i, j, k);
  }

  [[nodiscard]] std::size_t row(std::size_t j, std::size_t k) const { return row_stride() * (k * (count(1) + 1) + j); }
  [[nodiscard]] std::size_t record(std::size_t i, std::size_t j, std::size_t k) const {
    return row(j, k) + record_size * i;
  }
  [[nodiscard]] std::size_t cell(std::size_t i, std::size_t j, std::size_t k) const {
    return cell_grid().index(i, j, k);
  }
  /// Whether a point, in units of cells from the lower corner, is in the domain. A point that is not a number is not.
  [[nodiscard]] bool contains(const Vec3& in_cells) const {
    return (in_cells.array() >= 0).all() && (in_cells.array() <= Vec3(cells[0], cells[1], cells[2]).array()).all();
  }
  /// Such a point in the rest frame.
  [[nodiscard]] Vec3 point(const Vec3& in_cells) const { return lower_m + in_cells.cwiseProduct(cell_size_m); }
  /// The cell of such a point in the domain.
  [[nodiscard]] CellPosition locate(const Vec3& in_cells) const {
    const auto index = [&](std::size_t axis) {
      return std::min(static_cast<std::size_t>(in_cells[static_cast<Eigen::Index>(axis)]), count(axis) - 1);
    };
    const std::size_t i = index(0), j = index(1), k = index(2);
    return {i, j, k, in_cells - Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k))};
  }
  /// Distance of such a point to the domain.
  [[nodiscard]] double distance_m(const Vec3& in_cells) const {
    const Vec3 upper(cells[0], cells[1], cells[2]);
    return (-in_cells).cwiseMax(in_cells - upper).cwiseMax(0.0).cwiseProduct(cell_size_m).norm();
  }
  [[nodiscard]] std::size_t mask_words() const { return (cell_count() + 63) / 64; }

  bool operator==(const GridShape& other) const {
    return lower_m == other.lower_m && cell_size_m == other.cell_size_m && cells == other.cells;
  }
};

}  // namespace musclebench
