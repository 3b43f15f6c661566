// Nodes of several constraints, one a SIMD lane. Included by each file that is compiled once for every kind of SIMD,
// after highway.h. No product is fused with a sum, so that every kind gives the same bits.

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/vec_lanes-inl.hpp"
#include "core/constraints/constraint_lanes.hpp"
#include "core/pbd/node_rows.hpp"

#if defined(MUSCLEBENCH_NODE_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_NODE_LANES_INL
#undef MUSCLEBENCH_NODE_LANES_INL
#else
#define MUSCLEBENCH_NODE_LANES_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<double, constraint_lanes>;
using Lane = hn::Vec<Lanes>;
using VecLanes = VecLanesOf<Lane>;
using LaneMask = hn::Mask<Lanes>;
constexpr std::size_t lane_count = hn::MaxLanes(Lanes());
static_assert(constraint_lanes % lane_count == 0);

struct NodeLanes {
  VecLanes at;
  Lane inverse_mass;
};

/// Loads the rows at `offsets` (`row_offset`), a node a lane. The rows are read as they lie in memory; two rows of four
/// doubles fill a vector of eight, and a vector of two holds half a row.
HWY_INLINE NodeLanes load_nodes(const NodeRow* rows, const std::int32_t* offsets) {
  const Lanes d;
  const double* start = &rows->x;
  const auto row = [&](std::size_t lane) { return start + offsets[lane]; };
#if HWY_TARGET == HWY_SCALAR
  return {{hn::Load(d, row(0)), hn::Load(d, row(0) + 1), hn::Load(d, row(0) + 2)}, hn::Load(d, row(0) + 3)};
#elif HWY_MAX_BYTES == 16
  const Lane xy0 = hn::Load(d, row(0)), zw0 = hn::Load(d, row(0) + 2);
  const Lane xy1 = hn::Load(d, row(1)), zw1 = hn::Load(d, row(1) + 2);
  return {{hn::InterleaveLower(d, xy0, xy1), hn::InterleaveUpper(d, xy0, xy1), hn::InterleaveLower(d, zw0, zw1)},
          hn::InterleaveUpper(d, zw0, zw1)};
#else
  const auto rows_of = [&](std::size_t lane) {
#if HWY_MAX_BYTES == 32
    return hn::Load(d, row(lane));
#else
    const hn::Half<Lanes> half;
    return hn::Combine(d, hn::Load(half, row(lane + 4)), hn::Load(half, row(lane)));
#endif
  };
  const Lane r0 = rows_of(0), r1 = rows_of(1), r2 = rows_of(2), r3 = rows_of(3);
  const Lane xz01 = hn::InterleaveLower(d, r0, r1), yw01 = hn::InterleaveUpper(d, r0, r1);
  const Lane xz23 = hn::InterleaveLower(d, r2, r3), yw23 = hn::InterleaveUpper(d, r2, r3);
  return {{hn::OddEvenBlocks(hn::SwapAdjacentBlocks(xz23), xz01), hn::OddEvenBlocks(hn::SwapAdjacentBlocks(yw23), yw01),
           hn::OddEvenBlocks(xz23, hn::SwapAdjacentBlocks(xz01))},
          hn::OddEvenBlocks(yw23, hn::SwapAdjacentBlocks(yw01))};
#endif
}

/// The inverse of `load_nodes`: calls `write(tag, values, location)` for each row or part of one.
template <typename Write>
HWY_INLINE void write_nodes(const NodeLanes& nodes, NodeRow* rows, const std::int32_t* offsets, const Write& write) {
  const Lanes d;
  double* start = &rows->x;
  const auto row = [&](std::size_t lane) { return start + offsets[lane]; };
  const auto& [x, y, z] = nodes.at;
  const Lane w = nodes.inverse_mass;
#if HWY_TARGET == HWY_SCALAR
  write(d, x, row(0));
  write(d, y, row(0) + 1);
  write(d, z, row(0) + 2);
  write(d, w, row(0) + 3);
#elif HWY_MAX_BYTES == 16
  write(d, hn::InterleaveLower(d, x, y), row(0));
  write(d, hn::InterleaveLower(d, z, w), row(0) + 2);
  write(d, hn::InterleaveUpper(d, x, y), row(1));
  write(d, hn::InterleaveUpper(d, z, w), row(1) + 2);
#else
  const auto store_rows = [&](Lane values, std::size_t lane) {
#if HWY_MAX_BYTES == 32
    write(d, values, row(lane));
#else
    const hn::Half<Lanes> half;
    write(half, hn::LowerHalf(half, values), row(lane));
    write(half, hn::UpperHalf(half, values), row(lane + 4));
#endif
  };
  const Lane xz01 = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(z), x);
  const Lane xz23 = hn::OddEvenBlocks(z, hn::SwapAdjacentBlocks(x));
  const Lane yw01 = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(w), y);
  const Lane yw23 = hn::OddEvenBlocks(w, hn::SwapAdjacentBlocks(y));
  store_rows(hn::InterleaveLower(d, xz01, yw01), 0);
  store_rows(hn::InterleaveUpper(d, xz01, yw01), 1);
  store_rows(hn::InterleaveLower(d, xz23, yw23), 2);
  store_rows(hn::InterleaveUpper(d, xz23, yw23), 3);
#endif
}

/// Only padding lanes may name the same row.
HWY_INLINE void store_nodes(const NodeLanes& nodes, NodeRow* rows, const std::int32_t* offsets) {
  write_nodes(nodes, rows, offsets, [](auto d, auto values, double* at) { hn::Store(values, d, at); });
}

/// Adds to the positions in the rows: what was loaded of them need not be kept in registers until then. The rows of all
/// lanes differ, but for padding.
HWY_INLINE void add_to_nodes(const VecLanes& change, NodeRow* rows, const std::int32_t* offsets) {
  write_nodes({change, hn::Zero(Lanes())}, rows, offsets,
              [](auto d, auto values, double* at) { hn::Store(hn::Add(hn::Load(d, at), values), d, at); });
}

/// One row as the vectors that hold it.
struct RowVector {
  using Tag = hn::CappedTag<double, 4>;
  static constexpr std::size_t parts = 4 / hn::MaxLanes(Tag());
  std::array<hn::Vec<Tag>, parts> values;
};

HWY_INLINE RowVector load_row(const NodeRow& row) {
  RowVector loaded;
  for (std::size_t i = 0; i < RowVector::parts; ++i) {
    loaded.values[i] = hn::Load(RowVector::Tag(), &row.x + i * (4 / RowVector::parts));
  }
  return loaded;
}
HWY_INLINE void store_row(const RowVector& vector, NodeRow& row) {
  for (std::size_t i = 0; i < RowVector::parts; ++i) {
    hn::Store(vector.values[i], RowVector::Tag(), &row.x + i * (4 / RowVector::parts));
  }
}
HWY_INLINE RowVector operator+(RowVector a, const RowVector& b) {
  for (std::size_t i = 0; i < RowVector::parts; ++i) a.values[i] = hn::Add(a.values[i], b.values[i]);
  return a;
}
HWY_INLINE RowVector operator-(RowVector a, const RowVector& b) {
  for (std::size_t i = 0; i < RowVector::parts; ++i) a.values[i] = hn::Sub(a.values[i], b.values[i]);
  return a;
}
HWY_INLINE RowVector operator*(double factor, RowVector a) {
  for (auto& value : a.values) value = hn::Mul(hn::Set(RowVector::Tag(), factor), value);
  return a;
}

}  // namespace
}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
