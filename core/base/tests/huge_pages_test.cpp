#include "core/base/huge_pages.hpp"

#include <cinttypes>
#include <cstddef>
#include <cstdio>
#include <fstream>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <numeric>
#include <string>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// kB of the mapping about `address` that are in huge pages, by the system's own account; -1 where it gives none.
long huge_kilobytes_about(std::uintptr_t address) {
  std::ifstream maps("/proc/self/smaps");
  bool is_it = false;
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t begin = 0;
    std::uintptr_t end = 0;
    long kilobytes = 0;
    if (std::sscanf(line.c_str(), "%" SCNxPTR "-%" SCNxPTR " ", &begin, &end) == 2) {
      is_it = begin <= address && address < end;
    } else if (is_it && std::sscanf(line.c_str(), "AnonHugePages: %ld", &kilobytes) == 1) {
      return kilobytes;
    }
  }
  return -1;
}

enum class How { collapsed, on_first_use };

/// Asks for a single one, by hand.
bool grants_huge_pages(How how) {
  constexpr std::size_t page = std::size_t{2} << 20U;
  auto* memory =
      static_cast<std::byte*>(mmap(nullptr, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
  if (memory == MAP_FAILED) {
    return false;
  }
  std::byte* start = memory + (page - reinterpret_cast<std::uintptr_t>(memory) % page) % page;
  if (how == How::on_first_use) (void)madvise(start, page, MADV_HUGEPAGE);
  *start = std::byte{1};
  const bool is_granted = how == How::collapsed ? madvise(start, page, 25 /* MADV_COLLAPSE */) == 0
                                                : huge_kilobytes_about(reinterpret_cast<std::uintptr_t>(start)) > 0;
  munmap(memory, 2 * page);
  return is_granted;
}

TEST(HugePages, TakeOverWhatIsThereAndChangeNothing) {
  std::vector<int> numbers(std::size_t{1} << 22U);  // 16 MiB
  std::iota(numbers.begin(), numbers.end(), 0);
  const long before = huge_kilobytes_about(reinterpret_cast<std::uintptr_t>(numbers.data()));
  move_to_huge_pages();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    ASSERT_EQ(numbers[i], static_cast<int>(i));
  }
  const long kilobytes = huge_kilobytes_about(reinterpret_cast<std::uintptr_t>(numbers.data()));
  if (!grants_huge_pages(How::collapsed) || before >= 12 * 1024) {
    GTEST_SKIP() << "this system grants no pages of 2 MiB, or all by itself";
  }
  EXPECT_GE(kilobytes, 12 * 1024);
}

TEST(HugePages, AreReservedForWhatTheHeapGrowsBy) {
#ifdef __GLIBC__
  constexpr int never = 1 << 30;
  const bool is_set = mallopt(M_MMAP_THRESHOLD, never) != 0 && mallopt(M_TRIM_THRESHOLD, never) != 0;
  reserve_huge_pages(std::size_t{32} << 20U);
  const std::vector<char> used(std::size_t{24} << 20U, 1);
  if (!is_set || used.data() >= sbrk(0)) {
    GTEST_SKIP() << "a heap of its own, such as a sanitizer's";
  }
  if (!grants_huge_pages(How::on_first_use)) {
    GTEST_SKIP() << "this system grants no pages of 2 MiB";
  }
  // Not at the beginning, which may lie before the first huge page and is a mapping of its own then.
  EXPECT_GE(huge_kilobytes_about(reinterpret_cast<std::uintptr_t>(&used[used.size() / 2])), 20 * 1024);
#endif
}

}  // namespace
}  // namespace musclebench
