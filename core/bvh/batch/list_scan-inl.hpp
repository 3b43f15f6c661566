// Scans of long lists with the widest vectors of the CPU. Included by each file that is compiled once for every
// kind of SIMD, after highway.h.
#if defined(MUSCLEBENCH_LIST_SCAN) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_LIST_SCAN
#undef MUSCLEBENCH_LIST_SCAN
#else
#define MUSCLEBENCH_LIST_SCAN
#endif

#include <array>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "core/bvh/batch/bound_list.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro

namespace hn = hwy::HWY_NAMESPACE;

using Wide = hn::CappedTag<float, BoundList::padding>;
using WideVec = hn::Vec<Wide>;

/// The index of the smallest of many numbers; of equal ones the first in its lane.
class Lowest {
  using Indices = hn::RebindToSigned<Wide>;

 public:
  HWY_INLINE Lowest() : m_least(hn::Set(Wide(), far_away)), m_first(hn::Zero(Indices())) {}

  HWY_INLINE void update(WideVec numbers, std::size_t first) {
    const auto lower = hn::Lt(numbers, m_least);
    m_least = hn::IfThenElse(lower, numbers, m_least);
    m_first =
        hn::IfThenElse(hn::RebindMask(Indices(), lower), hn::Set(Indices(), static_cast<std::int32_t>(first)), m_first);
  }

  [[nodiscard]] HWY_INLINE std::size_t index() const { return index_in(lane_of(m_least)); }

  /// With the index of the smallest number of the other lanes; where these are empty, any index of the list.
  [[nodiscard]] HWY_INLINE std::array<std::size_t, 2> two_indices() const {
    const std::size_t lane = lane_of(m_least);
    const auto its_own = hn::Eq(hn::Iota(Indices(), 0), hn::Set(Indices(), static_cast<std::int32_t>(lane)));
    const WideVec others = hn::IfThenElse(hn::RebindMask(Wide(), its_own), hn::Set(Wide(), far_away), m_least);
    return {index_in(lane), index_in(lane_of(others))};
  }

 private:
  [[nodiscard]] static HWY_INLINE std::size_t lane_of(WideVec least) {
    const auto lanes = hn::RebindMask(Indices(), hn::Eq(least, hn::MinOfLanes(Wide(), least)));
    return static_cast<std::size_t>(hn::FindFirstTrue(Indices(), lanes));
  }

  [[nodiscard]] HWY_INLINE std::size_t index_in(std::size_t lane) const {
    alignas(64) std::int32_t first[BoundList::padding];
    hn::Store(m_first, Indices(), first);
    return static_cast<std::size_t>(first[lane]) + lane;
  }

  WideVec m_least;
  hn::Vec<Indices> m_first;
};

/// The bounds from `first` on, at `offset` from the middle of the list's box.
HWY_INLINE WideVec bounds_at(const BoundList& list, std::size_t first, WideVec from,
                             const std::array<float, 3>& offset) {
  const Wide w;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    from = hn::MulAdd(hn::LoadU(w, list.slope[axis].data() + first), hn::Set(w, offset[axis]), from);
  }
  return from;
}

/// Finds the lowest bounds of a list that is not empty.
HWY_INLINE Lowest lowest(const BoundList& list, const std::array<float, 3>& offset) {
  Lowest lowest;
  for (std::size_t first = 0; first < list.count; first += hn::Lanes(Wide())) {
    lowest.update(bounds_at(list, first, hn::LoadU(Wide(), list.value.data() + first), offset), first);
  }
  return lowest;
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
