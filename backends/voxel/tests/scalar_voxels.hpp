#pragma once

#include <cstddef>
#include <cstdint>

#include "backends/voxel/voxel_kernel.hpp"

// The grid looked up point by point, without lanes: what the kernel has to repeat to the bit.
namespace musclebench {

/// A NaN is in no cell.
inline bool is_between(const Vec3& scaled, const Vec3& first, const Vec3& end) {
  return scaled.x() >= first.x() && scaled.y() >= first.y() && scaled.z() >= first.z() && scaled.x() < end.x() &&
         scaled.y() < end.y() && scaled.z() < end.z();
}

inline bool is_kept(const VoxelGrid& grid, const Vec3& scaled) {
  return is_between(scaled, grid.view().first, grid.view().end);
}

/// `scaled` is a point in units of cells from the grid's lower corner.
inline bool contains_scaled(const VoxelGrid& grid, const Vec3& scaled) {
  if (!is_kept(grid, scaled)) return false;
  const VoxelView view = grid.view();
  const auto along = [&](Eigen::Index axis) {
    return static_cast<std::size_t>(scaled[axis]) - static_cast<std::size_t>(view.first[axis]);
  };
  const Vec3 count = view.end - view.first;
  const std::size_t row = along(2) * static_cast<std::size_t>(count.y()) + along(1);
  const std::size_t cell = row * static_cast<std::size_t>(count.x()) + along(0);
  return ((view.bits[cell / 64] >> (cell % 64)) & 1U) != 0;
}

inline bool leaves_out_scaled(const VoxelGrid& grid, const Vec3& scaled) {
  return is_between(scaled, Vec3::Zero(), grid.view().counts) && !is_kept(grid, scaled);
}

/// `point` in the bone's rest frame.
inline bool contains(const VoxelGrid& grid, const Vec3& point) {
  return contains_scaled(grid, (point - grid.lower()).cwiseQuotient(grid.cell_size_m()));
}

/// Each product and each sum rounded by itself, from left to right.
inline Vec3 to_cells(const VoxelMap& map, const Vec3& position) {
  const auto along = [&](Eigen::Index row) {
    double sum = map.to_cells(row, 0) * position.x();
    sum += map.to_cells(row, 1) * position.y();
    sum += map.to_cells(row, 2) * position.z();
    return sum + map.offset[row];
  };
  return {along(0), along(1), along(2)};
}

}  // namespace musclebench
