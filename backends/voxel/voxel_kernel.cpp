#include "backends/voxel/voxel_kernel.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/voxel/voxel_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "core/base/point_lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

/// Of an affine map, a row, in lanes.
struct MapRow {
  Vec x, y, z, offset;

  MapRow(const VoxelMap& map, Eigen::Index row)
      : x(set(map.to_cells(row, 0))),
        y(set(map.to_cells(row, 1))),
        z(set(map.to_cells(row, 2))),
        offset(set(map.offset[row])) {}
  [[nodiscard]] HWY_INLINE Vec apply(const Vec3Lanes& p) const {
    return hn::Add(add_product(sum_of_products(x, p.x, y, p.y), z, p.z), offset);
  }
};

/// Comparisons that a NaN fails.
HWY_INLINE hn::Mask<Lanes> is_between(const Vec3Lanes& at, const Vec3& first, const Vec3& end) {
  const auto along = [](Vec v, double low, double high)
                         HWY_ATTR { return hn::And(hn::Ge(v, set(low)), hn::Lt(v, set(high))); };
  return hn::And(hn::And(along(at.x, first.x(), end.x()), along(at.y, first.y(), end.y())),
                 along(at.z, first.z(), end.z()));
}

/// The index of the cell at this corner, one of those that are kept.
HWY_INLINE hn::Vec<hn::RebindToUnsigned<Lanes>> cell_index(const VoxelView& grid, const Vec3Lanes& corner) {
  const Vec3 count = grid.end - grid.first;
  const Vec x = hn::Sub(corner.x, set(grid.first.x()));
  const Vec y = hn::Sub(corner.y, set(grid.first.y()));
  const Vec z = hn::Sub(corner.z, set(grid.first.z()));
  return whole(add_product(x, add_product(y, z, set(count.y())), set(count.x())));
}

HWY_INLINE std::uint64_t bits_of(hn::Mask<Lanes> mask) {
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(Lanes(), mask, bytes.data());
  return bytes[0] & ((1U << lane_count) - 1);
}

void look_up_lanes(const VoxelView& grid, const VoxelMap& map, const double* positions, const int* nodes,
                   std::size_t count, VoxelBlock& block) {
  const Lanes d;
  const MapRow row_x(map, 0), row_y(map, 1), row_z(map, 2);
  const bool is_part = grid.end - grid.first != grid.counts;
  block.in_set = block.left_out = 0;
  for (std::size_t i = 0; i < count; i += lane_count) {
    const std::size_t here = HWY_MIN(lane_count, count - i);
    const Vec3Lanes p = load_positions(positions, nodes + i, here);
    Vec3Lanes at{row_x.apply(p), row_y.apply(p), row_z.apply(p)};
    hn::Store(at.x, d, block.x.data() + i);
    hn::Store(at.y, d, block.y.data() + i);
    hn::Store(at.z, d, block.z.data() + i);
    const auto kept = hn::And(is_between(at, grid.first, grid.end), hn::FirstN(d, here));
    if (is_part) {
      const auto in_grid = hn::And(is_between(at, Vec3::Zero(), grid.counts), hn::FirstN(d, here));
      block.left_out |= bits_of(hn::AndNot(kept, in_grid)) << i;
    }
    if (hn::AllFalse(d, kept)) continue;
    // The other lanes read the first cell that is kept.
    const auto corner = [&](Vec v, double first) HWY_ATTR { return hn::IfThenElse(kept, hn::Floor(v), set(first)); };
    at = {corner(at.x, grid.first.x()), corner(at.y, grid.first.y()), corner(at.z, grid.first.z())};
    block.in_set |= bits_of(hn::And(kept, has_bit(grid.bits, cell_index(grid, at)))) << i;
  }
}

HWY_INLINE Vec3Lanes load(const VoxelBlock& block, std::size_t first) {
  const Lanes d;
  return {hn::Load(d, block.x.data() + first), hn::Load(d, block.y.data() + first),
          hn::Load(d, block.z.data() + first)};
}

HWY_INLINE Vec length_m(const Vec3Lanes& cells, const Vec3& cell_size_m) {
  const Vec x = hn::Mul(cells.x, set(cell_size_m.x()));
  const Vec y = hn::Mul(cells.y, set(cell_size_m.y()));
  const Vec z = hn::Mul(cells.z, set(cell_size_m.z()));
  return hn::Sqrt(hn::Add(sum_of_products(x, x, y, y), hn::Mul(z, z)));
}

/// The corner of the cell, of those that are kept, that is the nearest to each point.
HWY_INLINE Vec3Lanes nearest_corner(const VoxelView& grid, const Vec3Lanes& at) {
  const auto along = [](Vec v, double first, double end) HWY_ATTR {
    // A NaN becomes the first cell.
    return hn::Floor(hn::IfThenElse(hn::Ge(v, set(first)), hn::Min(v, set(end - 1)), set(first)));
  };
  return {along(at.x, grid.first.x(), grid.end.x()), along(at.y, grid.first.y(), grid.end.y()),
          along(at.z, grid.first.z(), grid.end.z())};
}

HWY_INLINE Vec distance_to_grid_m(const VoxelView& grid, const Vec3Lanes& at) {
  const auto beyond = [](Vec v, double count)
                          HWY_ATTR { return hn::Max(hn::Max(hn::Neg(v), hn::Sub(v, set(count))), set(0)); };
  return length_m({beyond(at.x, grid.counts.x()), beyond(at.y, grid.counts.y()), beyond(at.z, grid.counts.z())},
                  grid.cell_size_m);
}

/// From a point in a cell that is kept; infinite where none is left out.
HWY_INLINE Vec distance_to_left_out_m(const VoxelView& grid, const Vec3Lanes& at) {
  Vec nearest = set(std::numeric_limits<double>::infinity());
  const auto along = [&](Vec v, Eigen::Index axis) HWY_ATTR {
    const Vec size = set(grid.cell_size_m[axis]);
    const double first = grid.first[axis], end = grid.end[axis];
    if (first > 0) nearest = hn::Min(nearest, hn::Mul(size, hn::Sub(v, set(first))));
    if (end < grid.counts[axis]) nearest = hn::Min(nearest, hn::Mul(size, hn::Sub(set(end), v)));
  };
  along(at.x, 0);
  along(at.y, 1);
  along(at.z, 2);
  return nearest;
}

void find_cells(const VoxelView& grid, std::size_t count, const VoxelBlock& block, std::uint64_t* cells) {
  for (std::size_t i = 0; i < count; i += lane_count) {
    hn::Store(cell_index(grid, nearest_corner(grid, load(block, i))), hn::RebindToUnsigned<Lanes>(), cells + i);
  }
}

/// `clearance_m` holds the distances of the middles of the nearest cells; from there to the point they change by no
/// more than that way.
void take_way_off(const VoxelView& grid, std::size_t count, VoxelBlock& block) {
  const Lanes d;
  const bool is_part = grid.end - grid.first != grid.counts;
  for (std::size_t i = 0; i < count; i += lane_count) {
    const Vec3Lanes at = load(block, i);
    const Vec3Lanes corner = nearest_corner(grid, at);
    const auto from_middle = [](Vec v, Vec low) HWY_ATTR { return hn::Sub(v, hn::Add(low, set(0.5))); };
    const Vec way_m = length_m({from_middle(at.x, corner.x), from_middle(at.y, corner.y), from_middle(at.z, corner.z)},
                               grid.cell_size_m);
    const Vec to_set_m = hn::Sub(hn::Load(d, block.clearance_m.data() + i), way_m);
    const Vec to_grid_m = distance_to_grid_m(grid, at);
    Vec clearance_m = hn::Max(to_grid_m, to_set_m);
    if (is_part) {
      // Of what is beyond a border of a part, the cells are not known.
      clearance_m =
          hn::IfThenElse(hn::Gt(to_grid_m, set(0)), to_grid_m, hn::Min(to_set_m, distance_to_left_out_m(grid, at)));
    }
    hn::Store(hn::Sub(clearance_m, set(grid.rounding_m)), d, block.clearance_m.data() + i);
  }
}

}  // namespace

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(look_up_lanes);
HWY_EXPORT(find_cells);
HWY_EXPORT(take_way_off);

static_assert(sizeof(Vec3) == 3 * sizeof(double), "positions are read as a row of numbers");

void look_up(const VoxelGrid& grid, const VoxelMap& map, std::span<const Vec3> positions, std::span<const int> nodes,
             VoxelBlock& block) {
  HWY_DYNAMIC_DISPATCH(look_up_lanes)
  (grid.view(), map, positions.data()->data(), nodes.data(), nodes.size(), block);
}

void find_clearances(const VoxelGrid& grid, std::size_t count, VoxelBlock& block) {
  const VoxelView view = grid.view();
  alignas(64) std::array<std::uint64_t, VoxelBlock::capacity> cells;
  HWY_DYNAMIC_DISPATCH(find_cells)(view, count, block, cells.data());
  for (std::size_t n = 0; n < count; ++n) {
    block.clearance_m[n] = grid.clearances().distance_m(cells[n]);
  }
  HWY_DYNAMIC_DISPATCH(take_way_off)(view, count, block);
}

}  // namespace musclebench
#endif
