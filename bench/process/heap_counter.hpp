#pragma once

#include <cstdint>

namespace musclebench {

/// Heap allocations of this process so far, in any thread. A program that links this counts every
/// malloc, calloc, realloc and operator new, its libraries' too; under a sanitizer, which has an allocator of its own,
/// and with another C library than glibc only the operators new.
std::uint64_t heap_allocations();

}  // namespace musclebench
