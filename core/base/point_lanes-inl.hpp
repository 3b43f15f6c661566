// Points in double precision, one a SIMD lane. Included by each file that is compiled once for every kind of SIMD,
// after highway.h.
#if defined(MUSCLEBENCH_POINT_LANES) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_POINT_LANES
#undef MUSCLEBENCH_POINT_LANES
#else
#define MUSCLEBENCH_POINT_LANES
#endif

#include <array>
#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro

namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Every operation is rounded by itself, none is fused, so that all kinds of SIMD give the same bits. Four lanes at
// most: a detection is a short burst between milliseconds of scalar code, in which powering up the 512-bit units costs
// more than they save.
#if HWY_HAVE_SCALABLE
using Lanes = hn::CappedTag<double, 2>;
#else
using Lanes = hn::CappedTag<double, 4>;
#endif
using Vec = hn::Vec<Lanes>;
constexpr std::size_t lane_count = hn::MaxLanes(Lanes());

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

/// Whether bit `index` of `words` is set, lane by lane.
HWY_INLINE hn::Mask<Lanes> has_bit(const std::uint64_t* words, hn::Vec<hn::RebindToUnsigned<Lanes>> index) {
  const hn::RebindToUnsigned<Lanes> integers;
  const hn::RebindToSigned<Lanes> indices;
  const auto word = hn::GatherIndex(integers, words, hn::BitCast(indices, hn::ShiftRight<6>(index)));
  const auto bit = hn::Shl(hn::Set(integers, 1), hn::And(index, hn::Set(integers, 63)));
  return hn::RebindMask(Lanes(), hn::TestBit(word, bit));
}

struct Vec3Lanes {
  Vec x, y, z;
};

/// Three numbers at `row(lane)` for each lane. Through registers: what is stored in parts and read whole stalls (store
/// forwarding).
template <typename Tag, typename Row>
HWY_INLINE Vec3Lanes load_rows(Tag d, const Row& row) {
#if HWY_TARGET == HWY_SCALAR
  return {hn::Set(d, row(0)[0]), hn::Set(d, row(0)[1]), hn::Set(d, row(0)[2])};
#else
  const hn::FixedTag<double, 2> pair;
  const auto pair_of = [&](std::size_t lane) HWY_ATTR {
    const double *even = row(lane), *odd = row(lane + 1);
    const auto xy_even = hn::LoadU(pair, even), xy_odd = hn::LoadU(pair, odd);
    return std::array{hn::InterleaveLower(pair, xy_even, xy_odd), hn::InterleaveUpper(pair, xy_even, xy_odd),
                      hn::InterleaveLower(pair, hn::Set(pair, even[2]), hn::Set(pair, odd[2]))};
  };
  const auto low = pair_of(0);
  if constexpr (hn::MaxLanes(d) == 2) {
    return {low[0], low[1], low[2]};
  } else {
    const auto high = pair_of(2);
    return {hn::Combine(d, high[0], low[0]), hn::Combine(d, high[1], low[1]), hn::Combine(d, high[2], low[2])};
  }
#endif
}

/// The first `count` of the nodes' positions; the other lanes hold that of the first.
HWY_INLINE Vec3Lanes load_positions(const double* positions, const int* nodes, std::size_t count) {
  return load_rows(Lanes(), [&](std::size_t lane) {
    return positions + 3 * static_cast<std::size_t>(nodes[lane < count ? lane : 0]);
  });
}

}  // namespace

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
