#include "bench/commands/effect_options.hpp"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

std::vector<std::string> split(std::string_view text, char at) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(at, begin), text.size());
    parts.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

EffectOverride parse_added(const std::string& text) {
  EffectOverride change{.location = "--effect " + text, .name = text.substr(0, text.find(':'))};
  if (change.name.empty() || text.ends_with(':')) {
    throw InputError(change.location, "has to read NAME or NAME:key=value,key=value, such as gravity:z_m_per_s2=-1.62");
  }
  if (change.name.size() < text.size()) {
    const EffectEntry* entry = find_effect(change.name);  // which words are words; else refused later
    change.values =
        parse_assignments(split(std::string_view(text).substr(change.name.size() + 1), ','), change.location,
                          entry == nullptr ? std::vector<ParameterSpec>{} : entry->parameters);
  }
  return change;
}

}  // namespace

void add_effect_options(CLI::App& command, EffectOptions& options) {
  command.add_option("--effect", options.added,
                     "NAME[:key=value,...]: add an effect or change its parameters; overrides scene and preset; may "
                     "be repeated");
  command.add_option("--no-effect", options.removed, "NAME: remove an effect of the scene or preset; may be repeated");
}

std::vector<EffectOverride> effect_overrides(const EffectOptions& options) {
  std::vector<EffectOverride> changes;
  for (const std::string& text : options.added) changes.push_back(parse_added(text));
  for (const std::string& name : options.removed) {
    changes.push_back({.location = "--no-effect " + name, .name = name, .is_removed = true});
  }
  return changes;
}

}  // namespace musclebench
