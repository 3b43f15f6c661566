// Addressing of cell values and their transposition into SIMD lanes. Included by each file that is compiled once for
// every kind of SIMD, after highway.h.
#if defined(MUSCLEBENCH_CELL_VALUES) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_CELL_VALUES
#undef MUSCLEBENCH_CELL_VALUES
#else
#define MUSCLEBENCH_CELL_VALUES
#endif

#include <array>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "backends/sdf/grid/cubic_cell.hpp"
#include "backends/sdf/grid/field_lanes-inl.hpp"
#include "backends/sdf/grid/grid_shape.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro

namespace {

/// Offsets of the runs of the points' cells from the field's first value: the run along the edge x at (y, z) has index
/// 2 y + z.
struct Runs {
  alignas(32) std::array<std::array<std::uint64_t, lane_count>, 4> begin;
};

struct CellLocation {
  Vec3Lanes corner;
  Vec3Lanes at;  ///< in [0, 1]^3
};

HWY_INLINE CellLocation locate_in_cell(const FieldView& field, const FieldBlock& block, std::size_t first) {
  const Lanes d;
  const auto corner = [&](Vec v, double cells) HWY_ATTR { return hn::Min(hn::Floor(v), set(cells - 1)); };
  const Vec x = hn::Load(d, block.x.data() + first);
  const Vec y = hn::Load(d, block.y.data() + first);
  const Vec z = hn::Load(d, block.z.data() + first);
  const Vec3Lanes low{corner(x, field.cells[0]), corner(y, field.cells[1]), corner(z, field.cells[2])};
  return {low, {hn::Sub(x, low.x), hn::Sub(y, low.y), hn::Sub(z, low.z)}};
}

HWY_INLINE void find_runs(const FieldView& field, const Vec3Lanes& corner, Runs& runs) {
  const hn::RebindToUnsigned<Lanes> integers;
  // As in GridShape::record: two values of the last record of a row are missing.
  const double stride = static_cast<double>(GridShape::record_size) * (field.cells[0] + 1) - 2;
  const double layer = (field.cells[1] + 1) * stride;
  const Vec row = add_product(corner.y, corner.z, set(field.cells[1] + 1));
  const Vec first = add_product(hn::Mul(corner.x, set(GridShape::record_size)), row, set(stride));
  const auto store = [&](double up, std::size_t run)
                         HWY_ATTR { hn::Store(whole(hn::Add(first, set(up))), integers, runs.begin[run].data()); };
  store(0, 0);
  store(layer, 1);
  store(stride, 2);
  store(layer + stride, 3);
}

/// What a cell takes from one of its runs: its first vertex and the nodes of the edges that leave it along y, z and x,
/// then the second vertex and its nodes along y and z.
struct Run {
  Vec near, near_y1, near_y2, near_z1, near_z2, x1, x2, far, far_y1, far_y2, far_z1, far_z2;
};

HWY_INLINE Run load_run(const FieldView& field, const Runs& runs, std::size_t run) {
  Vec c[CubicCell::run_size];
  for (std::size_t n = 0; n < CubicCell::run_size; n += lane_count) {
    const auto row = [&](std::size_t lane) HWY_ATTR { return load_wide(field.values + runs.begin[run][lane] + n); };
    transpose(Lanes(), row, c + n);
  }
  return {c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10], c[11]};
}

/// Prefetches what a cell reads of its runs.
HWY_INLINE void fetch(const FieldView& field, const Runs& runs) {
  for (const auto& run : runs.begin) {
    for (const std::uint64_t begin : run) {
      __builtin_prefetch(field.values + begin);
      __builtin_prefetch(field.values + begin + CubicCell::run_size - 1);
    }
  }
}

}  // namespace

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
