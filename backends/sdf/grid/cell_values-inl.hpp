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
#include <cstring>

#include <hwy/highway.h>

#include "backends/sdf/grid/cubic_cell.hpp"
#include "backends/sdf/grid/field_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro

namespace {

/// Byte offsets of the runs of the points' cells from the field's first value: the run along the edge x at (y, z) has
/// index 2 y + z.
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

template <typename Values>
HWY_INLINE void find_runs(const FieldView& field, const Vec3Lanes& corner, Runs& runs) {
  const hn::RebindToUnsigned<Lanes> integers;
  const Vec row = add_product(corner.y, corner.z, set(field.cells[1] + 1));
  const double up_z = field.cells[1] + 1;
  const auto store = [&](Vec begin, double up, std::size_t run)
                         HWY_ATTR { hn::Store(whole(hn::Add(begin, set(up))), integers, runs.begin[run].data()); };
  if (field.band == nullptr) {
    const double stride = static_cast<double>(Values::record_bytes) * (field.cells[0] + 1) - Values::missing_bytes;
    const Vec begin = add_product(hn::Mul(corner.x, set(Values::record_bytes)), row, set(stride));
    store(begin, 0, 0);
    store(begin, up_z * stride, 1);
    store(begin, stride, 2);
    store(begin, up_z * stride + stride, 3);
    return;
  }
  const double stride = field.cells[0] + 1;
  const Vec vertex = add_product(corner.x, row, set(stride));
  store(vertex, 0, 0);
  store(vertex, up_z * stride, 1);
  store(vertex, stride, 2);
  store(vertex, up_z * stride + stride, 3);
  for (auto& run : runs.begin) {
    for (std::uint64_t& begin : run) {
      begin = Values::record_bytes * field.band->record(begin);
    }
  }
}

/// What a cell takes from one of its runs: its first vertex and the nodes of the edges that leave it along y, z and x,
/// then the second vertex and its nodes along y and z.
struct Run {
  Vec near, near_y1, near_y2, near_z1, near_z2, x1, x2, far, far_y1, far_y2, far_z1, far_z2;
};

struct PlainValues {
  static constexpr std::size_t record_bytes = GridShape::record_size * sizeof(float);
  static constexpr std::size_t missing_bytes = 2 * sizeof(float);
  static constexpr std::size_t run_bytes = CubicCell::run_size * sizeof(float);

  HWY_INLINE static Run load(const FieldView& field, const Runs& runs, std::size_t run) {
    Vec c[CubicCell::run_size];
    for (std::size_t n = 0; n < CubicCell::run_size; n += lane_count) {
      const auto row = [&](std::size_t lane) HWY_ATTR {
        const void* from = static_cast<const unsigned char*>(field.values) + runs.begin[run][lane];
        return load_wide(static_cast<const float*>(from) + n);
      };
      transpose(Lanes(), row, c + n);
    }
    return {c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10], c[11]};
  }
};

struct CompactValues {
  static constexpr std::size_t record_bytes = sizeof(CompactRecord);
  static constexpr std::size_t missing_bytes = 0;
  static constexpr std::size_t run_bytes = 2 * sizeof(CompactRecord);

  /// The vertex's value of a record, and its steps in pairs.
  struct Record {
    Word own, y, z, x;
  };

  HWY_INLINE static Run load(const FieldView& field, const Runs& runs, std::size_t run) {
    const Words words;
    const Record a = load_record(words, field, runs.begin[run], 0);
    const Record b = load_record(words, field, runs.begin[run], sizeof(CompactRecord));
    const auto value = [&](Word own, hn::Vec<hn::RebindToSigned<Words>> steps, std::size_t node) HWY_ATTR {
      return widen(hn::Add(own, hn::Mul(hn::ConvertTo(words, steps), hn::Set(words, field.steps[node]))));
    };
    const auto first = [&](Word own, Word steps, std::size_t node)
                           HWY_ATTR { return value(own, hn::ShiftRight<16>(hn::ShiftLeft<16>(bits(steps))), node); };
    const auto second = [&](Word own, Word steps, std::size_t node)
                            HWY_ATTR { return value(own, hn::ShiftRight<16>(bits(steps)), node); };
    return {widen(a.own),          first(a.own, a.y, 0),  second(a.own, a.y, 1), first(a.own, a.z, 2),
            second(a.own, a.z, 3), first(a.own, a.x, 4),  second(a.own, a.x, 5), widen(b.own),
            first(b.own, b.y, 0),  second(b.own, b.y, 1), first(b.own, b.z, 2),  second(b.own, b.z, 3)};
  }

 private:
  HWY_INLINE static hn::Vec<hn::RebindToSigned<Words>> bits(Word word) {
    return hn::BitCast(hn::RebindToSigned<Words>(), word);
  }

  template <typename Tag>
  HWY_INLINE static Record load_record(Tag words, const FieldView& field,
                                       const std::array<std::uint64_t, lane_count>& begins, std::size_t offset) {
    const auto begin = [&](std::size_t lane) {
      return static_cast<const unsigned char*>(field.values) + begins[lane] + offset;
    };
#if HWY_TARGET == HWY_SCALAR
    std::array<float, 4> row;
    std::memcpy(row.data(), begin(0), sizeof row);
    return {hn::Set(words, row[0]), hn::Set(words, row[1]), hn::Set(words, row[2]), hn::Set(words, row[3])};
#else
    const hn::FixedTag<float, 4> quad;
    const auto row = [&](std::size_t lane)
                         HWY_ATTR { return hn::LoadU(quad, reinterpret_cast<const float*>(begin(lane))); };
    if constexpr (hn::MaxLanes(words) == 2) {
      const auto low = hn::InterleaveLower(quad, row(0), row(1));
      const auto high = hn::InterleaveUpper(quad, row(0), row(1));
      return {hn::LowerHalf(words, low), hn::UpperHalf(words, low), hn::LowerHalf(words, high),
              hn::UpperHalf(words, high)};
    } else {
      const auto r0 = row(0), r1 = row(1), r2 = row(2), r3 = row(3);
      const auto low_02 = hn::InterleaveLower(quad, r0, r2);
      const auto low_13 = hn::InterleaveLower(quad, r1, r3);
      const auto high_02 = hn::InterleaveUpper(quad, r0, r2);
      const auto high_13 = hn::InterleaveUpper(quad, r1, r3);
      return {hn::InterleaveLower(quad, low_02, low_13), hn::InterleaveUpper(quad, low_02, low_13),
              hn::InterleaveLower(quad, high_02, high_13), hn::InterleaveUpper(quad, high_02, high_13)};
    }
#endif
  }
};

/// Prefetches what a cell reads of its runs.
template <typename Values>
HWY_INLINE void fetch(const FieldView& field, const Runs& runs) {
  for (const auto& run : runs.begin) {
    for (const std::uint64_t begin : run) {
      const auto* from = static_cast<const unsigned char*>(field.values) + begin;
      __builtin_prefetch(from);
      __builtin_prefetch(from + Values::run_bytes - 1);
    }
  }
}

}  // namespace

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
