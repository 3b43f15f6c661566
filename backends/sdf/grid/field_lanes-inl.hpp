// SIMD lanes of points of a field. Included by each file that is compiled once for every kind of SIMD, after highway.h.
#if defined(MUSCLEBENCH_FIELD_LANES) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_FIELD_LANES
#undef MUSCLEBENCH_FIELD_LANES
#else
#define MUSCLEBENCH_FIELD_LANES
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "backends/sdf/grid/field_block.hpp"
#include "core/base/point_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro

namespace {

using Words = hn::Rebind<float, Lanes>;
using Word = hn::Vec<Words>;
static_assert(lane_count <= FieldBlock::most_lanes);

/// Appends the wanted points to a block.
HWY_INLINE void append(const Vec3Lanes& at, hn::Vec<hn::RebindToUnsigned<Lanes>> query, hn::Mask<Lanes> wanted,
                       FieldBlock& block) {
  const Lanes d;
  const hn::RebindToUnsigned<Lanes> integers;
  const std::size_t to = block.count;
  if (hn::AllTrue(d, wanted)) {
    hn::StoreU(at.x, d, block.x.data() + to);
    hn::StoreU(at.y, d, block.y.data() + to);
    hn::StoreU(at.z, d, block.z.data() + to);
    hn::StoreU(query, integers, block.query.data() + to);
    block.count += lane_count;
    return;
  }
  hn::CompressStore(at.x, wanted, d, block.x.data() + to);
  hn::CompressStore(at.y, wanted, d, block.y.data() + to);
  hn::CompressStore(at.z, wanted, d, block.z.data() + to);
  block.count += hn::CompressStore(query, hn::RebindMask(integers, wanted), integers, block.query.data() + to);
}

HWY_INLINE Vec widen(Word values) { return hn::PromoteTo(Lanes(), values); }
HWY_INLINE Vec load_wide(const float* values) { return widen(hn::LoadU(Words(), values)); }

/// Transposes a square matrix of the size of a vector: `row(lane)` becomes the lanes of its columns.
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

}  // namespace

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
