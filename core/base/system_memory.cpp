#include "core/base/system_memory.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();

std::size_t available_on_machine() {
  std::ifstream file("/proc/meminfo");
  std::string name;
  std::size_t kibibytes = 0;
  for (std::string rest; file >> name >> kibibytes; std::getline(file, rest)) {
    if (name == "MemAvailable:") {
      return kibibytes * 1024;
    }
  }
  return unlimited;
}

/// Of the process's address space (ulimit -v).
std::size_t available_address_space() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) {
    return unlimited;
  }
  std::size_t used_pages = 0;
  std::ifstream("/proc/self/statm") >> used_pages;
  const std::size_t used = used_pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  return limit.rlim_cur - std::min<std::size_t>(limit.rlim_cur, used);
}

/// Of the container (cgroup version 2).
std::size_t available_in_group() {
  std::size_t most = 0;
  std::size_t used = 0;
  if (!(std::ifstream("/sys/fs/cgroup/memory.max") >> most) ||
      !(std::ifstream("/sys/fs/cgroup/memory.current") >> used)) {
    return unlimited;
  }
  return most - std::min(most, used);
}

}  // namespace

std::size_t available_memory_bytes() {
  return std::min({available_on_machine(), available_address_space(), available_in_group()});
}

std::size_t resident_memory_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t total_pages = 0;
  std::size_t resident_pages = 0;
  file >> total_pages >> resident_pages;
  return resident_pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

std::size_t peak_resident_memory_bytes() {
  rusage usage{};
  return getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::size_t>(usage.ru_maxrss) * 1024 : 0;
}

void require_memory(std::size_t bytes, std::string_view key, std::string_view cure) {
  const std::size_t available = available_memory_bytes();
  if (bytes > available) {
    throw InputError(key, fmt::format("needs {:.0f} MB of memory, {:.0f} MB are there; {}",
                                      static_cast<double>(bytes) / 1e6, static_cast<double>(available) / 1e6, cure));
  }
}

}  // namespace musclebench
