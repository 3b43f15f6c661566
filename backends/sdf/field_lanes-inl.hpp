// How points of a field are computed side by side. Included by each file that is compiled once for every kind of SIMD,
// after highway.h.
#if defined(MUSCLEBENCH_FIELD_LANES) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_FIELD_LANES
#undef MUSCLEBENCH_FIELD_LANES
#else
#define MUSCLEBENCH_FIELD_LANES
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "backends/sdf/field_block.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro

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

}  // namespace

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
