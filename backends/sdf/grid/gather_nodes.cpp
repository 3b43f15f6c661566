#include "backends/sdf/grid/gather_nodes.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/sdf/grid/gather_nodes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "backends/sdf/grid/field_lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

std::array<double, 3> to_doubles(const std::array<std::int32_t, 3>& counts) {
  return {static_cast<double>(counts[0]), static_cast<double>(counts[1]), static_cast<double>(counts[2])};
}

HWY_INLINE Vec turned(const CellMap& map, Eigen::Index row, const Vec3Lanes& p) {
  const auto entry = [&](Eigen::Index column) HWY_ATTR { return set(map.to_cells(row, column)); };
  const Vec in_domain =
      hn::Add(sum_of_products(entry(0), p.x, entry(1), p.y), hn::Add(hn::Mul(entry(2), p.z), set(map.offset[row])));
  return hn::Sub(in_domain, set(map.first_cell[row]));
}

/// Whether the bit of each point's cell is set. All points are in the field.
HWY_INLINE hn::Mask<Lanes> is_wanted(const std::array<double, 3>& cells, const std::uint64_t* wanted,
                                     const Vec3Lanes& at) {
  const auto index = [&](Vec v, double count) HWY_ATTR { return hn::Min(hn::Floor(v), set(count - 1)); };
  const Vec row = add_product(index(at.y, cells[1]), index(at.z, cells[2]), set(cells[1]));
  return has_bit(wanted, whole(add_product(index(at.x, cells[0]), row, set(cells[0]))));
}

HWY_INLINE hn::Mask<Lanes> is_in_domain(const GridShape& shape, const Vec3Lanes& at) {
  const std::array<double, 3> before = to_doubles(shape.cells_before);
  const std::array<double, 3> cells = to_doubles(shape.cells);
  const std::array<double, 3> after = to_doubles(shape.cells_after);
  const auto is_within = [&](Vec v, std::size_t axis) HWY_ATTR {
    return hn::And(hn::Ge(v, set(-before[axis])), hn::Le(v, set(cells[axis] + after[axis])));
  };
  return hn::And(hn::And(is_within(at.x, 0), is_within(at.y, 1)), is_within(at.z, 2));
}

std::size_t gather(const GridShape& shape, const CellMap& map, const std::uint64_t* wanted, const double* positions,
                   const int* nodes, std::size_t count, std::size_t first, FieldBlock& block) {
  const std::array<double, 3> cells = to_doubles(shape.cells);
  const std::array<double, 3> lowest = shape.lowest();
  const std::array<double, 3> highest = shape.highest();
  const Lanes d;
  const hn::RebindToUnsigned<Lanes> integers;
  std::size_t i = 0;
  for (; i < count && block.count + lane_count <= FieldBlock::capacity; i += lane_count) {
    const std::size_t here = HWY_MIN(lane_count, count - i);
    const Vec3Lanes p = load_positions(positions, nodes + i, here);
    Vec3Lanes at{turned(map, 0, p), turned(map, 1, p), turned(map, 2, p)};
    const auto inside = [&](Vec v, std::size_t axis)
                            HWY_ATTR { return hn::And(hn::Ge(v, set(lowest[axis])), hn::Le(v, set(highest[axis]))); };
    auto wanted_lanes =
        hn::And(hn::And(inside(at.x, 0), inside(at.y, 1)), hn::And(inside(at.z, 2), hn::FirstN(d, here)));
    if (shape.is_part()) {
      const auto left_out = hn::AndNot(wanted_lanes, hn::And(is_in_domain(shape, at), hn::FirstN(d, here)));
      block.found_left_out |= !hn::AllFalse(d, left_out);
    }
    if (hn::AllFalse(d, wanted_lanes)) {
      continue;
    }
    if (wanted != nullptr) {
      at = {hn::IfThenElseZero(wanted_lanes, at.x), hn::IfThenElseZero(wanted_lanes, at.y),
            hn::IfThenElseZero(wanted_lanes, at.z)};
      wanted_lanes = hn::And(wanted_lanes, is_wanted(cells, wanted, at));
    }
    append(at, hn::Iota(integers, first + i), wanted_lanes, block);
  }
  return HWY_MIN(i, count);
}

}  // namespace

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(gather);

static_assert(sizeof(Vec3) == 3 * sizeof(double), "positions are read as a row of numbers");

std::size_t gather_nodes(const GridShape& shape, const CellMap& map, const std::uint64_t* wanted,
                         std::span<const Vec3> positions, std::span<const int> nodes, std::size_t first,
                         FieldBlock& block) {
  return HWY_DYNAMIC_DISPATCH(gather)(shape, map, wanted, positions.data()->data(), nodes.data(), nodes.size(), first,
                                      block);
}

}  // namespace musclebench
#endif
