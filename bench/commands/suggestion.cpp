#include "bench/commands/suggestion.hpp"

#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

std::vector<std::string> long_options_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) {
      names.push_back(fmt::format("--{}", name));
    }
  }
  return names;
}

}  // namespace

std::optional<std::string> suggestion(const CLI::App& app, std::span<const char* const> arguments) {
  if (arguments.empty() || std::string_view(arguments[0]).starts_with("-")) {
    return std::nullopt;
  }
  std::vector<std::string> commands;
  const CLI::App* chosen = nullptr;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    commands.push_back(command->get_name());
    chosen = command->get_name() == arguments[0] ? command : chosen;
  }
  if (chosen == nullptr) {
    return fmt::format("'{}' is no command; did you mean '{}'?", arguments[0], nearest_word(arguments[0], commands));
  }
  for (const std::string_view argument : arguments.subspan(1)) {
    const std::string_view name = argument.substr(0, argument.find('='));
    if (name.size() > 2 && name.starts_with("--") && chosen->get_option_no_throw(std::string(name)) == nullptr) {
      return fmt::format("'{}' is no option of `{}`; did you mean '{}'?", name, chosen->get_name(),
                         nearest_word(name, long_options_of(*chosen)));
    }
  }
  return std::nullopt;
}

}  // namespace musclebench
