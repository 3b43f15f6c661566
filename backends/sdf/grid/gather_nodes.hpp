#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "backends/sdf/grid/cell_map.hpp"
#include "backends/sdf/grid/field_block.hpp"
#include "backends/sdf/grid/grid_shape.hpp"

namespace musclebench {

/// Appends to `block` those of `nodes` (ascending indices into `positions`) that are in a cell of the grid whose bit in
/// `wanted` is set (all cells where it is null); `query` is the index in `nodes`, plus `first`. Stops where the block
/// is full; returns how many of `nodes` were visited. A NaN position is in no cell. Sets `found_left_out` where one of
/// them is in a cell of the domain that the grid leaves out, and never clears it.
std::size_t gather_nodes(const GridShape& shape, const CellMap& map, const std::uint64_t* wanted,
                         std::span<const Vec3> positions, std::span<const int> nodes, std::size_t first,
                         FieldBlock& block);

}  // namespace musclebench
