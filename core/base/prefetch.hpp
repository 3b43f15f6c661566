#pragma once

#include <cstddef>

namespace musclebench {

/// Prefetches these bytes into the CPU's caches. Only time depends on it, so the address may be anything.
[[gnu::always_inline]] inline void prefetch_bytes(const void* first, std::size_t bytes) {
  constexpr std::size_t cache_line = 64;
  for (std::size_t offset = 0; offset < bytes; offset += cache_line) {
    __builtin_prefetch(static_cast<const char*>(first) + offset);
  }
}

/// The same of a whole object.
template <typename T>
[[gnu::always_inline]] inline void prefetch(const T& what) {
  prefetch_bytes(&what, sizeof(T));
}

}  // namespace musclebench
