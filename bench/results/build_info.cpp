#include "bench/results/build_info.hpp"

#include <ctime>
#include <fstream>
#include <unistd.h>

#include "build_settings.hpp"
#include "git_state.hpp"

namespace musclebench {

BuildInfo build_info() { return {version_setting, git_state, compiler_setting, flags_setting, type_setting}; }

MachineInfo machine_info() {
  MachineInfo info{"unknown", static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)), "unknown", 0};
  std::ifstream cpus("/proc/cpuinfo");
  for (std::string line; std::getline(cpus, line);) {
    if (line.starts_with("model name")) {
      info.cpu = line.substr(line.find(':') + 2);
      break;
    }
  }
  std::ifstream("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor") >> info.governor;
  timespec resolution{};
  if (clock_getres(CLOCK_MONOTONIC, &resolution) == 0) {
    info.clock_resolution_ns = resolution.tv_nsec;
  }
  return info;
}

}  // namespace musclebench
