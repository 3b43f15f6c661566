#pragma once

namespace musclebench {

/// Exit codes of the program, beside 0.
enum ExitCode : int {
  exit_unexpected = 1,
  exit_not_held = 1,
  exit_bad_input = 2,
  exit_diverged = 3,
  exit_nondeterministic = 4,
  exit_out_of_time = 5,
  exit_unsupported = 6,
  exit_interrupted = 130
};

}  // namespace musclebench
