#include "core/effects/effect_registry.hpp"

#include <algorithm>
#include <stdexcept>

namespace musclebench {

const std::vector<EffectEntry>& effect_registry() {
  static const std::vector<EffectEntry> entries = [] {
    std::vector<EffectEntry> made;
    for (const EffectSource& source : effect_table()) {
      made.push_back(source.entry());
      if (made.back().name != source.name) {
        throw std::logic_error("the folder of effect '" + std::string(source.name) + "' has an entry with the name '" +
                               made.back().name + "'; give both one name");
      }
    }
    return made;
  }();
  return entries;
}

const EffectEntry* find_effect(std::string_view name) {
  const auto& entries = effect_registry();
  const auto found = std::ranges::find(entries, name, &EffectEntry::name);
  return found == entries.end() ? nullptr : &*found;
}

}  // namespace musclebench
