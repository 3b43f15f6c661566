#include "core/base/huge_pages.hpp"

#include <cstdint>
#ifdef __linux__
#include <sys/mman.h>
#endif

namespace musclebench {

void prefer_huge_pages([[maybe_unused]] std::span<const std::byte> memory) {
#ifdef __linux__
  constexpr std::uintptr_t page = std::uintptr_t{2} << 20U;
  constexpr int collapse_now = 25;  // MADV_COLLAPSE of Linux 6.1, which older headers don't name
  const auto begin = reinterpret_cast<std::uintptr_t>(memory.data());
  const std::uintptr_t first = (begin + page - 1) / page * page;
  const std::uintptr_t last = (begin + memory.size()) / page * page;
  if (first < last) {
    auto* start = reinterpret_cast<void*>(first);  // NOLINT(performance-no-int-to-ptr): aligned by hand
    (void)madvise(start, last - first, MADV_HUGEPAGE);
    (void)madvise(start, last - first, collapse_now);
  }
#endif
}

}  // namespace musclebench
