#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/base/grid_index.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A cell of a grid and a position in it, in [0, 1]^3.
struct CellPosition {
  std::size_t i, j, k;
  Vec3 at;
};

/// The regular grid of a cubic field: a box of cells, and the memory layout of the values at its nodes. Of the cells of
/// the domain it may keep a box only: then its indices and positions in units of cells count from that box's corner.
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
  std::array<std::int32_t, 3> cells_before{0, 0, 0};  ///< of the domain, that are left out along each axis
  std::array<std::int32_t, 3> cells_after{0, 0, 0};

  [[nodiscard]] std::size_t count(std::size_t axis) const { return static_cast<std::size_t>(cells[axis]); }
  [[nodiscard]] Vec3 upper_m() const {
    return lower_m + cell_size_m.cwiseProduct(vec(cells_before) + vec(cells) + vec(cells_after));
  }
  /// Added to whole numbers, so that a vertex is the same to the bit whatever is left out.
  [[nodiscard]] Vec3 vertex(int i, int j, int k) const { return point(Vec3(i, j, k)); }

  [[nodiscard]] bool is_part() const { return cells_before != no_cells || cells_after != no_cells; }
  /// The corner of the kept box from that of the domain, in units of cells.
  [[nodiscard]] Vec3 first_cell() const { return vec(cells_before); }

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

  [[nodiscard]] std::size_t row(std::size_t j, std::size_t k) const { return row_stride() * (k * (count(1) + 1) + j); }
  [[nodiscard]] std::size_t record(std::size_t i, std::size_t j, std::size_t k) const {
    return row(j, k) + record_size * i;
  }
  [[nodiscard]] std::size_t cell(std::size_t i, std::size_t j, std::size_t k) const {
    return cell_grid().index(i, j, k);
  }
  /// The range of points that are answered, along each axis. Cells next to one that is left out are kept for the values
  /// that they share with others; and on a face where the domain goes on, a point is in the next cell.
  [[nodiscard]] std::array<double, 3> lowest() const {
    std::array<double, 3> lowest{};
    for (std::size_t axis = 0; axis < 3; ++axis) lowest[axis] = cells_before[axis] == 0 ? 0 : 1;
    return lowest;
  }
  [[nodiscard]] std::array<double, 3> highest() const {
    std::array<double, 3> highest{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double count = cells[axis];
      highest[axis] = cells_after[axis] == 0 ? count : std::nextafter(count - 1, 0.0);
    }
    return highest;
  }
  /// Whether a point, in units of cells from the lower corner, is answered. A point that is not a number is not.
  [[nodiscard]] bool contains(const Vec3& in_cells) const {
    const std::array<double, 3> least = lowest();
    const std::array<double, 3> most = highest();
    return (in_cells.array() >= Vec3(least[0], least[1], least[2]).array()).all() &&
           (in_cells.array() <= Vec3(most[0], most[1], most[2]).array()).all();
  }
  /// Such a point in the rest frame.
  [[nodiscard]] Vec3 point(const Vec3& in_cells) const {
    return lower_m + cell_size_m.cwiseProduct(in_cells + first_cell());
  }
  /// The cell of such a point.
  [[nodiscard]] CellPosition locate(const Vec3& in_cells) const {
    const auto index = [&](std::size_t axis) {
      return std::min(static_cast<std::size_t>(in_cells[static_cast<Eigen::Index>(axis)]), count(axis) - 1);
    };
    const std::size_t i = index(0), j = index(1), k = index(2);
    return {i, j, k, in_cells - Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k))};
  }
  /// Distance of such a point to the domain.
  [[nodiscard]] double distance_m(const Vec3& in_cells) const {
    const Vec3 lower = -first_cell();
    const Vec3 upper = vec(cells) + vec(cells_after);
    return (lower - in_cells).cwiseMax(in_cells - upper).cwiseMax(0.0).cwiseProduct(cell_size_m).norm();
  }
  /// Distance of a point that is answered to the nearest one of the domain that is not; infinite where all are.
  [[nodiscard]] double distance_to_left_out_m(const Vec3& in_cells) const {
    double distance_m = std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      if (cells_before[axis] > 0) distance_m = std::min(distance_m, cell_size_m[a] * (in_cells[a] - lowest()[axis]));
      if (cells_after[axis] > 0) distance_m = std::min(distance_m, cell_size_m[a] * (highest()[axis] - in_cells[a]));
    }
    return distance_m;
  }

  /// With all cells of the domain.
  [[nodiscard]] GridShape whole() const {
    GridShape all{lower_m, cell_size_m, cells};
    for (std::size_t axis = 0; axis < 3; ++axis) all.cells[axis] += cells_before[axis] + cells_after[axis];
    return all;
  }
  /// Of this whole shape the cells that answer for `box` (rest frame), which may be unbounded; at least one.
  [[nodiscard]] GridShape part(const Eigen::AlignedBox3d& box) const {
    GridShape part = *this;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      const double count = cells[axis];
      const double first = std::floor((box.min()[a] - lower_m[a]) / cell_size_m[a]) - 1;
      const double end = std::ceil((box.max()[a] - lower_m[a]) / cell_size_m[a]) + 1;
      part.cells_before[axis] = static_cast<std::int32_t>(std::clamp(first, 0.0, count - 1));
      part.cells_after[axis] = static_cast<std::int32_t>(count - std::clamp(end, part.cells_before[axis] + 1.0, count));
      part.cells[axis] -= part.cells_before[axis] + part.cells_after[axis];
    }
    return part;
  }

  [[nodiscard]] std::size_t mask_words() const { return (cell_count() + 63) / 64; }

  bool operator==(const GridShape& other) const {
    return lower_m == other.lower_m && cell_size_m == other.cell_size_m && cells == other.cells &&
           cells_before == other.cells_before && cells_after == other.cells_after;
  }

 private:
  static constexpr std::array<std::int32_t, 3> no_cells{0, 0, 0};
  static Vec3 vec(const std::array<std::int32_t, 3>& counts) { return Vec3(counts[0], counts[1], counts[2]); }
};

}  // namespace musclebench
