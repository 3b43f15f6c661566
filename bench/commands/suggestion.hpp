#pragma once

#include <optional>
#include <span>
#include <string>

#include <CLI/App.hpp>

namespace musclebench {

/// What is wrong with a command line that `app` could not parse, where it is a word that is nearly one that `app`
/// knows: a command, or an option of the command. `arguments` are those after the program's name.
std::optional<std::string> suggestion(const CLI::App& app, std::span<const char* const> arguments);

}  // namespace musclebench
