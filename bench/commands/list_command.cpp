#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/commands/commands.hpp"
#include "bench/results/catalogue.hpp"

namespace musclebench {

namespace {

std::string word(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

std::string range_of(const Json& parameter) {
  if (parameter.contains("choices")) {
    return fmt::format("{}", fmt::join(parameter["choices"].get<std::vector<std::string>>(), " | "));
  }
  if (parameter["kind"] == "flag") {
    return "true | false";
  }
  return parameter["minimum"].is_null()
             ? ""
             : fmt::format("{} to {}", parameter["minimum"].get<double>(), parameter["maximum"].get<double>());
}

void print_parameters(const Json& parameters) {
  for (const Json& parameter : parameters) {
    const std::string value = word(parameter["default"]);
    fmt::print("    {:<24} {:<12} {:<6} {}\n", word(parameter["name"]), value.empty() ? "\"\"" : value,
               word(parameter["unit"]), word(parameter["help"]));
    if (const std::string range = range_of(parameter); !range.empty()) {
      fmt::print("    {:<44} [{}]\n", "", range);
    }
  }
}

void print_titles(const Json& entries) {
  for (const Json& entry : entries) {
    fmt::print("  {:<26} {}\n", word(entry["name"]), word(entry["title"]));
  }
}

void print_for_people(const Json& all) {
  fmt::print("Backends (--backend NAME --param key=value), with default and unit of each parameter:\n");
  for (const Json& backend : all["backends"]) {
    fmt::print("  {:<26} {} (response: {})\n", word(backend["name"]), word(backend["help"]),
               word(backend["default_response"]));
    fmt::print("    {:<24} {}\n", "implementation",
               word(backend["implementation"]).empty() ? "not stated" : word(backend["implementation"]));
    print_parameters(backend["parameters"]);
  }
  fmt::print("\nResponses (--response NAME, or response in [contact] of a scene):\n");
  for (const Json& response : all["responses"]) {
    fmt::print("  {:<26} {}\n", word(response["name"]), word(response["help"]));
  }
  fmt::print("\nEffects ([effects.NAME] in a scene):\n");
  for (const Json& effect : all["effects"]) {
    fmt::print("  {:<26} {}\n", word(effect["name"]), word(effect["help"]));
    print_parameters(effect["parameters"]);
  }
  fmt::print("\nLoop ([loop] in a scene, --loop key=value):\n");
  print_parameters(all["loop"]);
  fmt::print("\nPresets (--preset NAME):\n");
  print_titles(all["presets"]);
  fmt::print("\nScenes (lhdl/... need --data DIR or MUSCLEBENCH_DATA):\n");
  print_titles(all["scenes"]);
}

void print_limits(const Json& limits) {
  fmt::print("\nLimits: a run with a larger value is suspect:\n");
  for (const Json& limit : limits) {
    const std::string unit = word(limit["unit"]);
    fmt::print("  {:<26} {}{}\n", word(limit["name"]), word(limit["limit"]), unit.empty() ? "" : " " + unit);
    fmt::print("    {:<24} {}; {}\n", "", word(limit["help"]), word(limit["why"]));
  }
}

int list(bool as_json) {
  const Json all = catalogue();
  if (as_json) {
    fmt::print("{}\n", text_of(all, 1));
  } else {
    print_for_people(all);
    print_limits(all["results"]["limits"]);
  }
  return 0;
}

}  // namespace

void add_list_command(CLI::App& app, int& exit_code) {
  auto as_json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand(
      "list", "List backends, responses, effects, presets and scenes, with parameters, units and defaults");
  command->add_flag("--json", *as_json, "Print the list as JSON for programs, with the values that studies sweep");
  command->callback([as_json, &exit_code] { exit_code = list(*as_json); });
}

}  // namespace musclebench
