// Long lists, looked through with the widest vectors of the CPU. Included by each file that is compiled once for every
// kind of SIMD, after highway.h.
#if defined(MUSCLEBENCH_LIST_SCAN) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_LIST_SCAN
#undef MUSCLEBENCH_LIST_SCAN
#else
#define MUSCLEBENCH_LIST_SCAN
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "backends/sdf/packet_lists.hpp"

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

  [[nodiscard]] HWY_INLINE std::size_t place() const {
    const Places places;
    const auto lanes = hn::RebindMask(places, hn::Eq(m_least, hn::MinOfLanes(Wide(), m_least)));
    const auto lane = static_cast<std::size_t>(hn::FindFirstTrue(places, lanes));
    alignas(64) std::int32_t first[BoundList::padding];
    hn::Store(m_first, places, first);
    return static_cast<std::size_t>(first[lane]) + lane;
  }

 private:
  WideVec m_least;
  hn::Vec<Places> m_first;
};

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
