#include "bench/process/heap_counter.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MUSCLEBENCH_SANITIZED
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define MUSCLEBENCH_CLANG_THREAD_SANITIZER
#endif
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MUSCLEBENCH_SANITIZED
#endif
#endif

namespace {

// Set up before any code runs: the loader allocates, too.
constinit std::atomic<std::uint64_t> allocations{0};
constinit std::atomic<std::uint64_t> allocated_bytes{0};

void count(std::size_t bytes) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  allocated_bytes.fetch_add(bytes, std::memory_order_relaxed);
}

}  // namespace

#ifndef MUSCLEBENCH_SANITIZED

// glibc lets a program have an allocator of its own; ours counts and hands on. The operators new come through here.
extern "C" {

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): glibc's names.
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* block);
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

void* malloc(std::size_t size) noexcept {
  count(size);
  return __libc_malloc(size);
}

void* calloc(std::size_t number, std::size_t size) noexcept {
  count(number * size);
  return __libc_calloc(number, size);
}

void* realloc(void* block, std::size_t size) noexcept {
  count(size);
  return __libc_realloc(block, size);
}

void* memalign(std::size_t alignment, std::size_t size) noexcept {
  count(size);
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept { return memalign(alignment, size); }

int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  void* const made = memalign(alignment, size);
  if (made == nullptr) {
    return ENOMEM;
  }
  *block = made;
  return 0;
}

void free(void* block) noexcept { __libc_free(block); }

}  // extern "C"

#else

// Of the sanitizers' interface; GCC brings no header. Its sanitizers let a program replace the operators new, clang's
// thread sanitizer does not; all of them tell.
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void* block,
                                                                           std::size_t size),
                                                         void (*on_free)(const volatile void* block));

namespace {

[[maybe_unused]] const int is_told = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void* /*block*/, std::size_t size) { count(size); }, [](const volatile void* /*block*/) {});

}  // namespace

#endif

namespace musclebench {

HeapUse heap_use() {
  return {allocations.load(std::memory_order_relaxed), allocated_bytes.load(std::memory_order_relaxed)};
}

#ifdef MUSCLEBENCH_CLANG_THREAD_SANITIZER
const bool each_parallel_region_allocates = true;
#else
const bool each_parallel_region_allocates = false;
#endif

std::uint64_t heap_allocations() { return heap_use().allocations; }

}  // namespace musclebench
