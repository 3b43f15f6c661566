#pragma once

#include <string>

namespace musclebench {

/// What a program printed and how it ended.
struct Answer {
  int exit_code = 0;
  std::string text;

  /// What the line says that begins with the key; empty where there is none.
  [[nodiscard]] std::string of(const std::string& key) const;
};

/// Runs a command of the shell, its errors among what it prints.
Answer call(const std::string& command);

/// Why instructions can't be counted here; empty where they can.
std::string why_not_counted();

/// What callgrind counts in the function of effect_frames that makes and runs the simulation.
struct Counted {
  double instructions = 0;
  bool calls_effect = false;  ///< whether the function that makes `effect` ran
};

/// `effect`: whose calls are looked for; empty: none.
Counted count_instructions(const std::string& command, const std::string& effect = "");

}  // namespace musclebench
