#include "core/scene/effect_override.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

const EffectEntry& find_entry(const EffectOverride& change) {
  if (const EffectEntry* entry = find_effect(change.name)) {
    return *entry;
  }
  std::vector<std::string> known;
  for (const EffectEntry& entry : effect_registry()) known.push_back(entry.name);
  throw InputError(change.location,
                   fmt::format("'{}' is no effect; did you mean '{}'?", change.name, nearest_word(change.name, known)));
}

std::ptrdiff_t rank_of(std::string_view name) {
  return std::ranges::find(effect_registry(), name, &EffectEntry::name) - effect_registry().begin();
}

/// The values that the scene gives, overwritten by those of the change.
Parameters changed(const EffectEntry& entry, const Parameters* own, const EffectOverride& change) {
  std::map<std::string, ParameterValue> values = change.values;
  if (own != nullptr) {
    for (const auto& [key, value] : own->values()) {
      if (own->given(key)) values.emplace(key, value);
    }
  }
  return {entry.parameters, values, change.location};
}

}  // namespace

void override_effects(const std::vector<EffectOverride>& overrides, std::vector<SceneEffect>& effects) {
  std::set<std::string> seen;
  for (const EffectOverride& change : overrides) {
    const EffectEntry& entry = find_entry(change);
    if (!seen.insert(change.name).second) {
      throw InputError(change.location, fmt::format("names '{}' a second time; leave one out", change.name));
    }
    const auto own = std::ranges::find(effects, change.name, &SceneEffect::name);
    if (!change.is_removed) {
      SceneEffect made{change.name, changed(entry, own == effects.end() ? nullptr : &own->parameters, change)};
      if (own != effects.end()) {
        *own = std::move(made);
      } else {
        const auto after = std::ranges::find_if(
            effects, [&](const SceneEffect& other) { return rank_of(other.name) > rank_of(change.name); });
        effects.insert(after, std::move(made));
      }
    } else if (own != effects.end()) {
      effects.erase(own);
    } else {
      throw InputError(change.location,
                       fmt::format("neither the scene nor its preset has '{}'; leave the option out", change.name));
    }
  }
}

}  // namespace musclebench
