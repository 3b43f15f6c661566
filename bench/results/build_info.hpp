#pragma once

#include <string>

namespace musclebench {

/// How this program was made.
struct BuildInfo {
  std::string version;
  std::string git;  ///< `git describe`, with -dirty where the tree had changes; "unknown" outside a checkout
  std::string compiler;
  std::string flags;
  std::string type;
};

BuildInfo build_info();

/// The machine it runs on, as far as the system tells; "unknown" otherwise.
struct MachineInfo {
  std::string cpu;
  int cores = 0;
  std::string governor;
  long clock_resolution_ns = 0;
};

MachineInfo machine_info();

}  // namespace musclebench
