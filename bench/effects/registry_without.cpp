// The effects of a program that is built without one of them. CMake defines MUSCLEBENCH_ABSENT, its name, and puts the
// functions below in the place of its own, so that nothing of the effect is linked.
#include <algorithm>
#include <string_view>
#include <vector>

// The table of core under other names: what links this file takes its registry from here.
#define effect_registry whole_effect_registry
#define find_effect find_in_whole_registry
#include "core/effects/effect_registry.cpp"  // NOLINT(bugprone-suspicious-include): compiled with other names
#undef effect_registry
#undef find_effect

namespace musclebench {

// After the table, so that each name there means one function.
std::vector<ParameterSpec> absent_parameters() { return {}; }
std::unique_ptr<Effect> make_absent(const EffectInput& /*input*/, const Parameters& /*parameters*/) { return nullptr; }
std::unique_ptr<ContactStage> make_absent(const StageInput& /*input*/, const Parameters& /*parameters*/) {
  return nullptr;
}
void set_absent(Response& /*response*/, const Parameters& /*parameters*/) {}
void set_absent(ContactProperties& /*contacts*/, const Parameters& /*parameters*/) {}

const std::vector<EffectEntry>& effect_registry() {
  static const std::vector<EffectEntry> entries = [] {
    std::vector<EffectEntry> all = whole_effect_registry();
    all.erase(std::find_if(all.begin(), all.end(),
                           [](const EffectEntry& entry) { return entry.name == MUSCLEBENCH_ABSENT; }));
    return all;
  }();
  return entries;
}

const EffectEntry* find_effect(std::string_view name) {
  const auto& entries = effect_registry();
  const auto found = std::ranges::find(entries, name, &EffectEntry::name);
  return found == entries.end() ? nullptr : &*found;
}

}  // namespace musclebench
