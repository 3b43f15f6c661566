#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "backends/registry.hpp"
#include "bench/commands/commands.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/scene/scene.hpp"
#include "datasets/embedded/embedded_files.hpp"

namespace musclebench {

namespace {

std::string range_of(const ParameterSpec& spec) {
  if (!spec.choices.empty()) {
    return fmt::format("{}", fmt::join(spec.choices, " | "));
  }
  if (spec.kind == ParameterKind::flag) {
    return "true | false";
  }
  return spec.has_range() ? fmt::format("{} to {}", spec.minimum, spec.maximum) : "";
}

void print_parameters(const std::vector<ParameterSpec>& specs) {
  for (const ParameterSpec& spec : specs) {
    const std::string value = format_parameter_value(spec.default_value);
    fmt::print("    {:<24} {:<12} {:<6} {}\n", spec.name, value.empty() ? "\"\"" : value, spec.unit,
               spec.help);
    if (const std::string range = range_of(spec); !range.empty()) {
      fmt::print("    {:<44} [{}]\n", "", range);
    }
  }
}

int list() {
  fmt::print("Backends (--backend NAME --param key=value), with default and unit of each parameter:\n");
  for (const BackendEntry& entry : backend_registry()) {
    fmt::print("  {:<26} {} (response: {})\n", entry.name, entry.help,
               entry.response == ResponseKind::backtrack ? "backtrack" : "project");
    print_parameters(entry.parameters);
  }
  fmt::print("\nEffects ([effects.NAME] in a scene):\n");
  for (const EffectEntry& entry : effect_registry()) {
    fmt::print("  {:<26} {}\n", entry.name, entry.help);
    print_parameters(entry.parameters);
  }
  fmt::print("\nLoop ([loop] in a scene, --loop key=value):\n");
  print_parameters(loop_parameters());
  fmt::print("\nPresets (--preset NAME):\n");
  for (const EmbeddedFile& file : embedded_presets()) {
    fmt::print("  {}\n", file.name);
  }
  fmt::print("\nScenes (lhdl/... need --data DIR or MUSCLEBENCH_DATA):\n");
  for (const EmbeddedFile& file : embedded_scenes()) {
    fmt::print("  {}\n", file.name);
  }
  return 0;
}

}  // namespace

void add_list_command(CLI::App& app, int& exit_code) {
  app.add_subcommand("list", "Show backends, effects, scenes and their parameters with units and defaults")
      ->callback([&exit_code] { exit_code = list(); });
}

}  // namespace musclebench
