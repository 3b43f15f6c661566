#include <csignal>
#include <cstddef>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "bench/commands/command_line.hpp"
#include "core/base/huge_pages.hpp"

namespace {

/// Meshes are read, repaired and dropped one after the other. Memory that is given back in between comes as new pages
/// again, which costs a tenth of a run's set-up. A run gives it back once, before its first frame. Huge pages from the
/// start save another twentieth: copying into them, and page faults.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int never = 1 << 30;
  (void)mallopt(M_MMAP_THRESHOLD, never);
  (void)mallopt(M_TRIM_THRESHOLD, never);
  (void)mallopt(M_TOP_PAD, 32 << 20);
  constexpr std::size_t usual_bytes = std::size_t{256} << 20U;  // more comes in small pages at first
  musclebench::reserve_huge_pages(usual_bytes);
#endif
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): it escapes only where the complaint itself cannot be printed.
int main(int argc, char** argv) {
  keep_freed_memory();
  // A file that outgrows the limit (ulimit -f) is a failed write with its line, not the end at once.
  std::signal(SIGXFSZ, SIG_IGN);
  return musclebench::run_command_line(argc, argv);
}
