#pragma once

namespace musclebench {

/// Runs the command that the arguments name, the program's name first. What is wrong with them or with an input is one
/// line on standard error. Returns the exit code.
int run_command_line(int argc, const char* const* argv);

}  // namespace musclebench
