#include "core/base/machine_state.hpp"

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <sched.h>
#include <sys/resource.h>

namespace musclebench {
namespace {

/// "cpu MHz : 2399.998" of processor number `core`.
std::optional<double> mhz_of(int core) {
  std::ifstream cpus("/proc/cpuinfo");
  int processor = -1;
  for (std::string line; std::getline(cpus, line);) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    if (line.starts_with("processor")) processor = std::atoi(line.c_str() + colon + 1);
    if (processor == core && line.starts_with("cpu MHz")) {
      const double mhz = std::strtod(line.c_str() + colon + 1, nullptr);
      if (mhz > 0) return mhz;
    }
  }
  return std::nullopt;
}

template <typename Value>
std::optional<Value> first_word_of(const std::string& path) {
  std::ifstream file(path);
  Value value;
  if (file >> value) return value;
  return std::nullopt;
}

}  // namespace

ContextSwitches context_switches() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return {};
  return {usage.ru_nvcsw, usage.ru_nivcsw};
}

Nanoseconds process_cpu_ns() {
  timespec time{};
  if (clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time) != 0) return 0;
  return Nanoseconds{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

CpuSettings cpu_settings() {
  CpuSettings settings;
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) settings.allowed_cores = CPU_COUNT(&allowed);
  settings.nice = getpriority(PRIO_PROCESS, 0);
  const std::string cpus = "/sys/devices/system/cpu/";
  if (const auto boost = first_word_of<int>(cpus + "cpufreq/boost")) {
    settings.turbo = *boost == 1;
  } else if (const auto no_turbo = first_word_of<int>(cpus + "intel_pstate/no_turbo")) {
    settings.turbo = *no_turbo == 0;
  }
  if (const auto active = first_word_of<int>(cpus + "smt/active")) settings.smt = *active == 1;
  return settings;
}

MachineLoad machine_load() {
  const int core = sched_getcpu();
  return {first_word_of<double>("/proc/loadavg"), mhz_of(core),
          first_word_of<std::string>("/sys/devices/system/cpu/cpu" + std::to_string(core < 0 ? 0 : core) +
                                     "/cpufreq/scaling_governor")};
}

}  // namespace musclebench
