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

/// The unit is the end of the name, after the last word that is not a unit.
std::string unit_of(const std::string& name) {
  static constexpr std::pair<std::string_view, std::string_view> endings[] = {{"_rad_per_n_m", "rad/Nm"},
                                                                              {"_kg_per_m3", "kg/m3"},
                                                                              {"_m_per_n", "m/N"},
                                                                              {"_m_per_s2", "m/s2"},
                                                                              {"_per_s", "1/s"},
                                                                              {"_m3", "m3"},
                                                                              {"_rad", "rad"},
                                                                              {"_deg", "deg"},
                                                                              {"_kg", "kg"},
                                                                              {"_mm", "mm"},
                                                                              {"_s", "s"},
                                                                              {"_m", "m"}};
  for (const auto& [ending, unit] : endings) {
    if (name.ends_with(ending)) {
      return std::string(unit);
    }
  }
  return "";
}

std::string range_of(const ParameterSpec& spec) {
  if (!spec.choices.empty()) {
    return fmt::format("{}", fmt::join(spec.choices, " | "));
  }
  if (std::holds_alternative<bool>(spec.default_value)) {
    return "true | false";
  }
  return std::holds_alternative<std::string>(spec.default_value) ? ""
                                                                 : fmt::format("{} to {}", spec.minimum, spec.maximum);
}

void print_parameters(const std::vector<ParameterSpec>& specs) {
  for (const ParameterSpec& spec : specs) {
    const std::string value = format_parameter_value(spec.default_value);
    fmt::print("    {:<24} {:<12} {:<6} {}\n", spec.name, value.empty() ? "\"\"" : value, unit_of(spec.name),
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
