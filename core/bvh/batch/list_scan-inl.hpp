// Long lists, looked through with the widest vectors of the CPU. Included by each file that is compiled once for every
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

#include "core/bvh/batch/packet_lists.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro

namespace hn = hwy::HWY_NAMESPACE;

using Wide = hn::CappedTag<float, BoundList::padding>;
using WideVec = hn::Vec<Wide>;

/// The place of the smallest of many numbers, the first of several in its lane.
class Lowest {
  using Places = hn::RebindToSigned<Wide>;

 public:
  HWY_INLINE Lowest() : m_least(hn::Set(Wide(), packet_nowhere)), m_first(hn::Zero(Places())) {}

  HWY_INLINE void look(WideVec numbers, std::size_t first) {
    const auto lower = hn::Lt(numbers, m_least);
    m_least = hn::IfThenElse(lower, numbers, m_least);
    m_first =
        hn::IfThenElse(hn::RebindMask(Places(), lower), hn::Set(Places(), static_cast<std::int32_t>(first)), m_first);
  }

  [[nodiscard]] HWY_INLINE std::size_t place() const { return place_in(lane_of(m_least)); }

  /// With the place of the smallest number of the other lanes; where these are empty, any place that was looked at.
  [[nodiscard]] HWY_INLINE std::array<std::size_t, 2> two_places() const {
    const std::size_t lane = lane_of(m_least);
    const auto its_own = hn::Eq(hn::Iota(Places(), 0), hn::Set(Places(), static_cast<std::int32_t>(lane)));
    const WideVec others = hn::IfThenElse(hn::RebindMask(Wide(), its_own), hn::Set(Wide(), packet_nowhere), m_least);
    return {place_in(lane), place_in(lane_of(others))};
  }

 private:
  [[nodiscard]] static HWY_INLINE std::size_t lane_of(WideVec least) {
    const auto lanes = hn::RebindMask(Places(), hn::Eq(least, hn::MinOfLanes(Wide(), least)));
    return static_cast<std::size_t>(hn::FindFirstTrue(Places(), lanes));
  }

  [[nodiscard]] HWY_INLINE std::size_t place_in(std::size_t lane) const {
    alignas(64) std::int32_t first[BoundList::padding];
    hn::Store(m_first, Places(), first);
    return static_cast<std::size_t>(first[lane]) + lane;
  }

  WideVec m_least;
  hn::Vec<Places> m_first;
};

/// The bounds from `first` on at `way` from the middle of the list's box.
HWY_INLINE WideVec bounds_at(const BoundList& list, std::size_t first, WideVec from, const std::array<float, 3>& way) {
  const Wide w;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    from = hn::MulAdd(hn::LoadU(w, list.slope[axis].data() + first), hn::Set(w, way[axis]), from);
  }
  return from;
}

/// Where in a list, that is not empty, the lowest bounds are.
HWY_INLINE Lowest lowest(const BoundList& list, const std::array<float, 3>& way) {
  Lowest lowest;
  for (std::size_t first = 0; first < list.count; first += hn::Lanes(Wide())) {
    lowest.look(bounds_at(list, first, hn::LoadU(Wide(), list.value.data() + first), way), first);
  }
  return lowest;
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
