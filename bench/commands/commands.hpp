#pragma once

#include <CLI/App.hpp>

#include "bench/process/exit_code.hpp"

namespace musclebench {

// Each adds one subcommand, which sets `exit_code` when it runs.
void add_run_command(CLI::App& app, int& exit_code);
void add_record_command(CLI::App& app, int& exit_code);
void add_replay_command(CLI::App& app, int& exit_code);
void add_list_command(CLI::App& app, int& exit_code);
void add_check_command(CLI::App& app, int& exit_code);
void add_verify_command(CLI::App& app, int& exit_code);
void add_queries_command(CLI::App& app, int& exit_code);
void add_probe_command(CLI::App& app, int& exit_code);
void add_advise_command(CLI::App& app, int& exit_code);
void add_field_command(CLI::App& app, int& exit_code);
void add_hard_command(CLI::App& app, int& exit_code);

}  // namespace musclebench
