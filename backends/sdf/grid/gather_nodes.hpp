#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "backends/sdf/grid/cell_map.hpp"
#include "backends/sdf/grid/field_block.hpp"

namespace musclebench {

/// Appends to `block` those of `nodes` (ascending indices into `positions`) that are in a field of so many `cells`
/// along each axis and in a cell whose bit in `wanted` is set (all cells where it is null); `query` is the index in
/// `nodes`, plus `first`. Stops where the block is full; returns how many of `nodes` were visited. A NaN position is in
/// no cell.
std::size_t gather_nodes(const std::array<double, 3>& cells, const CellMap& map, const std::uint64_t* wanted,
                         std::span<const Vec3> positions, std::span<const int> nodes, std::size_t first,
                         FieldBlock& block);

}  // namespace musclebench
