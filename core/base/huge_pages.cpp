#include "core/base/huge_pages.hpp"

#ifdef __linux__
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <sys/mman.h>
#include <vector>
#endif

namespace musclebench {

#ifdef __linux__

namespace {

struct AddressRange {
  std::uintptr_t begin = 0;
  std::uintptr_t end = 0;
};

/// Written by this process alone and backed by no file: its heap, and the stacks of its threads, which look the same.
/// What is larger than any memory is only reserved (sanitizers do that) and left alone.
std::vector<AddressRange> heap_ranges() {
  constexpr std::uintptr_t largest = std::uintptr_t{1} << 42U;
  std::vector<AddressRange> ranges;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    AddressRange range;
    char permissions[5] = {};
    unsigned long long inode = 1;
    int name = 0;
    const int fields = std::sscanf(line.c_str(), "%" SCNxPTR "-%" SCNxPTR " %4s %*x %*s %llu %n", &range.begin,
                                   &range.end, permissions, &inode, &name);
    const bool is_heap = fields == 4 && inode == 0 && std::string(permissions) == "rw-p" &&
                         (name == static_cast<int>(line.size()) || line.substr(name) == "[heap]");
    if (is_heap && range.end - range.begin < largest) {
      ranges.push_back(range);
    }
  }
  return ranges;
}

}  // namespace

void move_to_huge_pages() {
  constexpr std::uintptr_t page = std::uintptr_t{2} << 20U;
  constexpr int collapse_now = 25;  // MADV_COLLAPSE of Linux 6.1, which older headers don't name
  for (const AddressRange& range : heap_ranges()) {
    const std::uintptr_t first = (range.begin + page - 1) / page * page;
    const std::uintptr_t last = range.end / page * page;
    for (std::uintptr_t address = first; address < last; address += page) {
      auto* start = reinterpret_cast<void*>(address);  // NOLINT(performance-no-int-to-ptr): aligned by hand
      (void)madvise(start, page, collapse_now);
    }
  }
}

void reserve_huge_pages(std::size_t bytes) {
  void* volatile reserved = std::malloc(bytes);  // volatile: else the compiler leaves both calls out
  std::free(reserved);
  constexpr std::uintptr_t page = std::uintptr_t{2} << 20U;
  for (const AddressRange& range : heap_ranges()) {
    const std::uintptr_t first = (range.begin + page - 1) / page * page;
    const std::uintptr_t last = range.end / page * page;
    if (first >= last) continue;
    auto* start = reinterpret_cast<void*>(first);  // NOLINT(performance-no-int-to-ptr): aligned by hand
    (void)madvise(start, last - first, MADV_HUGEPAGE);
  }
}

#else

void move_to_huge_pages() {}
void reserve_huge_pages(std::size_t /*bytes*/) {}

#endif

}  // namespace musclebench
