#include "backends/sdf/cubic_kernel.hpp"

#include <bit>
#include <cstddef>
#include <cstring>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/sdf/cubic_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// A point a lane. Every operation is rounded by itself, none is fused, so that all kinds of SIMD give the same bits.
// Four lanes at most: a detection is a short burst between milliseconds of scalar code, and registers of 64 bytes would
// have to be woken up for it, which costs more than they give.
#if HWY_HAVE_SCALABLE
using Lanes = hn::CappedTag<double, 2>;
#else
using Lanes = hn::CappedTag<double, FieldBlock::most_lanes>;
#endif
using Words = hn::Rebind<float, Lanes>;
using Vec = hn::Vec<Lanes>;
using Word = hn::Vec<Words>;
constexpr std::size_t lane_count = hn::MaxLanes(Lanes());
/// Vectors of points whose values are fetched before their turn.
constexpr std::size_t fetched_ahead = 4;

HWY_INLINE Vec set(double value) { return hn::Set(Lanes(), value); }
HWY_INLINE Vec sum_of_products(Vec a, Vec b, Vec c, Vec d) { return hn::Add(hn::Mul(a, b), hn::Mul(c, d)); }
/// a + b * c
HWY_INLINE Vec add_product(Vec a, Vec b, Vec c) { return hn::Add(a, hn::Mul(b, c)); }

/// Whole numbers from 0 to 2^52 as integers.
HWY_INLINE hn::Vec<hn::RebindToUnsigned<Lanes>> whole(Vec number) {
  const hn::RebindToUnsigned<Lanes> integers;
  const Vec magic = set(0x1p52);
  return hn::Xor(hn::BitCast(integers, hn::Add(number, magic)), hn::BitCast(integers, magic));
}

struct Vec3Lanes {
  Vec x, y, z;
};

// ---------------------------------------------------------------------------------------------------------- places

/// The first `count` of the nodes' positions; the other lanes hold that of the first.
HWY_INLINE Vec3Lanes load_positions(const double* positions, const int* nodes, std::size_t count) {
  const Lanes d;
  Vec3Lanes p{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  if (count == lane_count && nodes[lane_count - 1] - nodes[0] == static_cast<int>(lane_count - 1)) {
    hn::LoadInterleaved3(d, positions + 3 * static_cast<std::size_t>(nodes[0]), p.x, p.y, p.z);
    return p;
  }
  alignas(32) std::array<double, 3 * lane_count> row;
  for (std::size_t lane = 0; lane < lane_count; ++lane) {
    const double* position = positions + 3 * static_cast<std::size_t>(nodes[lane < count ? lane : 0]);
    row[lane] = position[0];
    row[lane_count + lane] = position[1];
    row[2 * lane_count + lane] = position[2];
  }
  return {hn::Load(d, row.data()), hn::Load(d, row.data() + lane_count), hn::Load(d, row.data() + 2 * lane_count)};
}

HWY_INLINE Vec turned(const CellMap& map, Eigen::Index row, const Vec3Lanes& p) {
  const auto entry = [&](Eigen::Index column) HWY_ATTR { return set(map.to_cells(row, column)); };
  return hn::Add(sum_of_products(entry(0), p.x, entry(1), p.y), hn::Add(hn::Mul(entry(2), p.z), set(map.offset[row])));
}

/// Whether the bit of each point's cell is set. All points are in the field.
HWY_INLINE hn::Mask<Lanes> is_wanted(const FieldView& field, const std::uint64_t* wanted, const Vec3Lanes& at) {
  const Lanes d;
  const hn::RebindToUnsigned<Lanes> integers;
  const hn::RebindToSigned<Lanes> places;
  const auto index = [&](Vec v, double cells) HWY_ATTR { return hn::Min(hn::Floor(v), set(cells - 1)); };
  const Vec row = add_product(index(at.y, field.cells[1]), index(at.z, field.cells[2]), set(field.cells[1]));
  const auto cell = whole(add_product(index(at.x, field.cells[0]), row, set(field.cells[0])));
  const auto word = hn::GatherIndex(integers, wanted, hn::BitCast(places, hn::ShiftRight<6>(cell)));
  const auto bit = hn::Shl(hn::Set(integers, 1), hn::And(cell, hn::Set(integers, 63)));
  return hn::RebindMask(d, hn::TestBit(word, bit));
}

HWY_INLINE void append(const Vec3Lanes& at, hn::Vec<hn::RebindToUnsigned<Lanes>> asker, hn::Mask<Lanes> asked,
                       FieldBlock& block) {
  const Lanes d;
  const hn::RebindToUnsigned<Lanes> integers;
  const std::size_t to = block.count;
  if (hn::AllTrue(d, asked)) {
    hn::StoreU(at.x, d, block.x.data() + to);
    hn::StoreU(at.y, d, block.y.data() + to);
    hn::StoreU(at.z, d, block.z.data() + to);
    hn::StoreU(asker, integers, block.asker.data() + to);
    block.count += lane_count;
    return;
  }
  hn::CompressStore(at.x, asked, d, block.x.data() + to);
  hn::CompressStore(at.y, asked, d, block.y.data() + to);
  hn::CompressStore(at.z, asked, d, block.z.data() + to);
  block.count += hn::CompressStore(asker, hn::RebindMask(integers, asked), integers, block.asker.data() + to);
}

std::size_t place(const FieldView& field, const CellMap& map, const std::uint64_t* wanted, const double* positions,
                  const int* nodes, std::size_t count, std::size_t first, FieldBlock& block) {
  const Lanes d;
  const hn::RebindToUnsigned<Lanes> integers;
  const Vec zero = hn::Zero(d);
  std::size_t i = 0;
  for (; i < count && block.count + lane_count <= FieldBlock::capacity; i += lane_count) {
    const std::size_t here = HWY_MIN(lane_count, count - i);
    const Vec3Lanes p = load_positions(positions, nodes + i, here);
    Vec3Lanes at{turned(map, 0, p), turned(map, 1, p), turned(map, 2, p)};
    const auto inside = [&](Vec v, double cells) HWY_ATTR { return hn::And(hn::Ge(v, zero), hn::Le(v, set(cells))); };
    auto asked = hn::And(hn::And(inside(at.x, field.cells[0]), inside(at.y, field.cells[1])),
                         hn::And(inside(at.z, field.cells[2]), hn::FirstN(d, here)));
    if (hn::AllFalse(d, asked)) {
      continue;
    }
    if (wanted != nullptr) {
      at = {hn::IfThenElseZero(asked, at.x), hn::IfThenElseZero(asked, at.y), hn::IfThenElseZero(asked, at.z)};
      asked = hn::And(asked, is_wanted(field, wanted, at));
    }
    append(at, hn::Iota(integers, first + i), asked, block);
  }
  return HWY_MIN(i, count);
}

// ---------------------------------------------------------------------------------------------------------- values

/// Where the runs of the points' cells begin: along the edges x at (y, z), at place 2 y + z, in bytes from the field's
/// first value.
struct Runs {
  alignas(32) std::array<std::array<std::uint64_t, lane_count>, 4> begin;
};

struct Place {
  Vec3Lanes corner;
  Vec3Lanes at;  ///< in [0, 1]^3
};

HWY_INLINE Place place_in_cell(const FieldView& field, const FieldBlock& block, std::size_t first) {
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

/// Turns a square of as many values as there are lanes: `row(lane)` becomes the lanes of its columns.
template <typename Tag, typename Row>
HWY_INLINE void transpose(Tag d, const Row& row, Vec* HWY_RESTRICT columns) {
#if HWY_TARGET == HWY_SCALAR
  (void)d;
  columns[0] = row(0);
#else
  if constexpr (hn::MaxLanes(d) == 2) {
    const auto r0 = row(0), r1 = row(1);
    columns[0] = hn::InterleaveLower(d, r0, r1);
    columns[1] = hn::InterleaveUpper(d, r0, r1);
  } else {
    const auto r0 = row(0), r1 = row(1), r2 = row(2), r3 = row(3);
    const auto even_01 = hn::InterleaveLower(d, r0, r1);
    const auto odd_01 = hn::InterleaveUpper(d, r0, r1);
    const auto even_23 = hn::InterleaveLower(d, r2, r3);
    const auto odd_23 = hn::InterleaveUpper(d, r2, r3);
    columns[0] = hn::ConcatLowerLower(d, even_23, even_01);
    columns[1] = hn::ConcatLowerLower(d, odd_23, odd_01);
    columns[2] = hn::ConcatUpperUpper(d, even_23, even_01);
    columns[3] = hn::ConcatUpperUpper(d, odd_23, odd_01);
  }
#endif
}

HWY_INLINE Vec widen(Word values) { return hn::PromoteTo(Lanes(), values); }
HWY_INLINE Vec load_wide(const float* values) { return widen(hn::LoadU(Words(), values)); }
HWY_INLINE Vec load_wide(const double* values) { return hn::LoadU(Lanes(), values); }

template <typename Scalar>
struct PlainValues {
  static constexpr std::size_t record_bytes = GridShape::record_size * sizeof(Scalar);
  static constexpr std::size_t missing_bytes = 2 * sizeof(Scalar);
  static constexpr std::size_t run_bytes = CubicCell::run_size * sizeof(Scalar);

  HWY_INLINE static Run load(const FieldView& field, const Runs& runs, std::size_t run) {
    Vec c[CubicCell::run_size];
    for (std::size_t n = 0; n < CubicCell::run_size; n += lane_count) {
      const auto row = [&](std::size_t lane) HWY_ATTR {
        const void* from = static_cast<const unsigned char*>(field.values) + runs.begin[run][lane];
        return load_wide(static_cast<const Scalar*>(from) + n);
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

  /// The own values of a record, and its steps two by two.
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

// ------------------------------------------------------------------------------------------------------ polynomial

/// Between four values at 00, 01, 10, 11 of p and q, with derivatives along both.
struct Blend {
  Vec value, of_p, of_q;
};

HWY_INLINE Blend blend(Vec v00, Vec v01, Vec v10, Vec v11, Vec p, Vec q) {
  const Vec low_q = hn::Sub(v01, v00);
  const Vec high_q = hn::Sub(v11, v10);
  const Vec low = add_product(v00, q, low_q);
  const Vec of_p = hn::Sub(add_product(v10, q, high_q), low);
  return {add_product(low, p, of_p), of_p, add_product(low_q, p, hn::Sub(high_q, low_q))};
}

/// Weights of the two nodes of an edge at t, and their slopes.
struct Weights {
  Vec first, second, first_slope, second_slope;
  Vec bubble;        ///< t (1 - t)
  Vec bubble_slope;  ///< of -4.5 t (1 - t)
};

HWY_INLINE Weights weights(Vec t) {
  const Vec bubble = hn::Mul(t, hn::Sub(set(1), t));
  const Vec bubble_slope = hn::Sub(hn::Mul(set(9), t), set(4.5));
  // 13.5 t (1 - t) (2/3 - t), and the same from the other end; their sum is 4.5 t (1 - t).
  const Vec first = hn::Mul(bubble, hn::Sub(set(9), hn::Mul(set(13.5), t)));
  const Vec first_slope = add_product(set(9), t, hn::Sub(hn::Mul(set(40.5), t), set(45)));
  return {first,       hn::Sub(hn::Mul(set(4.5), bubble), first),
          first_slope, hn::Sub(hn::Sub(set(0), bubble_slope), first_slope),
          bubble,      bubble_slope};
}

/// The part of the edges along one axis: value and derivatives along it and along the others.
struct Part {
  Vec value, along, of_p, of_q;
};

HWY_INLINE Part edges(const Weights& w, const Blend& first, const Blend& second) {
  return {sum_of_products(w.first, first.value, w.second, second.value),
          sum_of_products(w.first_slope, first.value, w.second_slope, second.value),
          sum_of_products(w.first, first.of_p, w.second, second.of_p),
          sum_of_products(w.first, first.of_q, w.second, second.of_q)};
}

template <typename Values>
HWY_INLINE void evaluate_lanes(const FieldView& field, const Runs& runs, FieldBlock& block, std::size_t first) {
  const auto [corner, at] = place_in_cell(field, block, first);
  const auto& [x, y, z] = at;
  const Run r00 = Values::load(field, runs, 0);
  const Run r01 = Values::load(field, runs, 1);
  const Run r10 = Values::load(field, runs, 2);
  const Run r11 = Values::load(field, runs, 3);

  // The trilinear part of the corners.
  const Blend low = blend(r00.near, r01.near, r10.near, r11.near, y, z);
  const Blend high = blend(r00.far, r01.far, r10.far, r11.far, y, z);
  const Vec linear_x = hn::Sub(high.value, low.value);
  const Vec linear = add_product(low.value, x, linear_x);
  const Vec linear_y = add_product(low.of_p, x, hn::Sub(high.of_p, low.of_p));
  const Vec linear_z = add_product(low.of_q, x, hn::Sub(high.of_q, low.of_q));

  const Weights wx = weights(x), wy = weights(y), wz = weights(z);
  const Part of_x = edges(wx, blend(r00.x1, r01.x1, r10.x1, r11.x1, y, z), blend(r00.x2, r01.x2, r10.x2, r11.x2, y, z));
  const Part of_y = edges(wy, blend(r00.near_y1, r01.near_y1, r00.far_y1, r01.far_y1, x, z),
                          blend(r00.near_y2, r01.near_y2, r00.far_y2, r01.far_y2, x, z));
  const Part of_z = edges(wz, blend(r00.near_z1, r10.near_z1, r00.far_z1, r10.far_z1, x, y),
                          blend(r00.near_z2, r10.near_z2, r00.far_z2, r10.far_z2, x, y));

  // The trilinear part counts (9 |xi|^2 - 19) / 8 times, xi over [-1, 1]^3.
  const Vec scale = hn::Sub(set(1), hn::Mul(set(4.5), hn::Add(hn::Add(wx.bubble, wy.bubble), wz.bubble)));
  const auto total = [](Vec of_linear, Vec a, Vec b, Vec c)
                         HWY_ATTR { return hn::Add(of_linear, hn::Add(hn::Add(a, b), c)); };
  const Lanes d;
  hn::Store(total(hn::Mul(scale, linear), of_x.value, of_y.value, of_z.value), d, block.value_m.data() + first);
  const auto store_slope = [&](Vec v, double per_m, double* to)
                               HWY_ATTR { hn::Store(hn::Mul(v, set(per_m)), d, to + first); };
  store_slope(total(sum_of_products(scale, linear_x, wx.bubble_slope, linear), of_x.along, of_y.of_p, of_z.of_p),
              field.cells_per_m[0], block.slope_x.data());
  store_slope(total(sum_of_products(scale, linear_y, wy.bubble_slope, linear), of_x.of_p, of_y.along, of_z.of_q),
              field.cells_per_m[1], block.slope_y.data());
  store_slope(total(sum_of_products(scale, linear_z, wz.bubble_slope, linear), of_x.of_q, of_y.of_q, of_z.along),
              field.cells_per_m[2], block.slope_z.data());
}

/// What a cell reads of its runs begins to come from memory.
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

template <typename Values>
HWY_INLINE void evaluate_all(const FieldView& field, FieldBlock& block) {
  std::array<Runs, fetched_ahead> runs;
  const std::size_t groups = (block.count + lane_count - 1) / lane_count;
  for (std::size_t group = 0; group < groups + fetched_ahead; ++group) {
    Runs& own = runs[group % fetched_ahead];
    if (group >= fetched_ahead) {
      evaluate_lanes<Values>(field, own, block, (group - fetched_ahead) * lane_count);
    }
    if (group < groups) {
      find_runs<Values>(field, place_in_cell(field, block, group * lane_count).corner, own);
      fetch<Values>(field, own);
    }
  }
}

void evaluate(const FieldView& field, FieldBlock& block) {
  switch (field.precision) {
    case FieldPrecision::compact:
      return evaluate_all<CompactValues>(field, block);
    case FieldPrecision::single_precision:
      return evaluate_all<PlainValues<float>>(field, block);
    case FieldPrecision::double_precision:
      return evaluate_all<PlainValues<double>>(field, block);
  }
}

}  // namespace
}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(place);
HWY_EXPORT(evaluate);

static_assert(sizeof(Vec3) == 3 * sizeof(double), "positions are read as a row of numbers");

std::size_t place_nodes(const FieldView& field, const CellMap& map, const std::uint64_t* wanted,
                        std::span<const Vec3> positions, std::span<const int> nodes, std::size_t first,
                        FieldBlock& block) {
  return HWY_DYNAMIC_DISPATCH(place)(field, map, wanted, positions.data()->data(), nodes.data(), nodes.size(), first,
                                     block);
}

void evaluate_block(const FieldView& field, FieldBlock& block) {
  if (block.count == 0) {
    return;
  }
  // Whole vectors are computed: the lanes that are left over ask once more for the last point.
  for (std::size_t n = block.count; n < block.count + FieldBlock::most_lanes; ++n) {
    block.x[n] = block.x[block.count - 1];
    block.y[n] = block.y[block.count - 1];
    block.z[n] = block.z[block.count - 1];
  }
  HWY_DYNAMIC_DISPATCH(evaluate)(field, block);
}

}  // namespace musclebench
#endif
