#pragma once

#include <optional>
#include <string>

#include "core/base/scoped_timer.hpp"

namespace musclebench {

/// How often the process's threads left the CPU so far.
struct ContextSwitches {
  long voluntary = 0;    ///< to wait for something
  long involuntary = 0;  ///< because the scheduler gave the CPU to others: a disturbed measurement

  ContextSwitches operator-(const ContextSwitches& earlier) const {
    return {voluntary - earlier.voluntary, involuntary - earlier.involuntary};
  }
  ContextSwitches& operator+=(const ContextSwitches& more) {
    voluntary += more.voluntary;
    involuntary += more.involuntary;
    return *this;
  }
};

ContextSwitches context_switches();

/// CPU time of all threads of the process so far, in nanoseconds.
Nanoseconds process_cpu_ns();

/// What else the machine is doing, as far as the system tells.
struct MachineLoad {
  std::optional<double> load_average_1m;
  std::optional<double> cpu_mhz;  ///< of the core that the caller runs on
  std::optional<std::string> governor;
};

MachineLoad machine_load();

/// What a time depends on beside the program and the load: set by who runs the machine.
struct CpuSettings {
  int allowed_cores = 0;  ///< that the process may run on; 1: it is pinned
  int nice = 0;
  std::optional<bool> turbo;
  std::optional<bool> smt;  ///< two threads share a core
};

CpuSettings cpu_settings();

/// The machine during the timed part of a measurement: what tells a disturbed one.
struct MachineState {
  ContextSwitches switches;  ///< within the timed regions
  MachineLoad before, after;
};

}  // namespace musclebench
