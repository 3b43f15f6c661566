#pragma once

#include <cstdint>

namespace musclebench {

/// Heap allocations of this process so far, in any thread. A program that links this counts every
/// malloc, calloc, realloc and operator new, its libraries' too; under a sanitizer, which has an allocator of its own,
/// those since the program's own code began.
std::uint64_t heap_allocations();

struct HeapUse {
  std::uint64_t allocations = 0;
  std::uint64_t bytes = 0;  ///< asked for in them; of a reallocation its whole new size
};

/// The same with bytes.
HeapUse heap_use();

/// Whether OpenMP itself allocates in each parallel region. It does under clang's thread sanitizer, whose observer of
/// OpenMP (Archer) tells it where threads synchronise.
extern const bool each_parallel_region_allocates;

}  // namespace musclebench
