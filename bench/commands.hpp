#pragma once

#include <CLI/App.hpp>

namespace musclebench {

/// Exit codes of the program, beside 0.
enum ExitCode : int {
  exit_unexpected = 1,
  exit_not_held = 1,
  exit_bad_input = 2,
  exit_diverged = 3,
  exit_nondeterministic = 4,
  exit_interrupted = 130
};

// Each adds one subcommand, which sets `exit_code` when it runs.
void add_run_command(CLI::App& app, int& exit_code);
void add_record_command(CLI::App& app, int& exit_code);
void add_replay_command(CLI::App& app, int& exit_code);
void add_list_command(CLI::App& app, int& exit_code);
void add_check_command(CLI::App& app, int& exit_code);
void add_verify_command(CLI::App& app, int& exit_code);
void add_probe_command(CLI::App& app, int& exit_code);
void add_advise_command(CLI::App& app, int& exit_code);
void add_field_command(CLI::App& app, int& exit_code);

}  // namespace musclebench
