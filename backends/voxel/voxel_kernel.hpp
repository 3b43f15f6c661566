#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "backends/voxel/voxel_grid.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// Maps world positions to units of a grid's cells from its lower corner, in one affine map.
struct VoxelMap {
  Mat3 to_cells;
  Vec3 offset;

  VoxelMap(const VoxelGrid& grid, const RigidMotion& pose)
      : to_cells(grid.cell_size_m().cwiseInverse().asDiagonal() * pose.rotation.transpose()),
        offset(-(to_cells * pose.translation_m) - grid.lower().cwiseQuotient(grid.cell_size_m())) {}
};

/// Nodes that are looked up together.
struct VoxelBlock {
  static constexpr std::size_t capacity = 64;
  using Lanes = std::array<double, capacity>;

  alignas(64) Lanes x, y, z;      ///< in units of cells
  std::uint64_t in_set = 0;       ///< a bit a node: its cell is set
  std::uint64_t left_out = 0;     ///< its cell is one of those that the grid leaves out
  alignas(64) Lanes clearance_m;  ///< see find_clearances

  [[nodiscard]] Vec3 cells(std::size_t n) const { return {x[n], y[n], z[n]}; }
};

/// Looks up at most `VoxelBlock::capacity` of the nodes (indices into `positions`). A position that is not finite is in
/// no cell.
void look_up(const VoxelGrid& grid, const VoxelMap& map, std::span<const Vec3> positions, std::span<const int> nodes,
             VoxelBlock& block);

/// Of a block's first `count` nodes that are in no set cell and in none that is left out: the radius of a sphere about
/// the node in which there is neither; not positive where that can't be told. The grid has its clearances.
void find_clearances(const VoxelGrid& grid, std::size_t count, VoxelBlock& block);

}  // namespace musclebench
