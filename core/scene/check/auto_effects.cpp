#include "core/scene/check/auto_effects.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/effects/effect_registry.hpp"
#include "core/scene/check/scene_check.hpp"

namespace musclebench {

namespace {

std::ptrdiff_t rank_of(std::string_view effect) {
  return std::ranges::find(effect_registry(), effect, &EffectEntry::name) - effect_registry().begin();
}

bool has_pair(const Scene& scene, MusclePair muscles) {
  return std::ranges::find(scene.muscle_pairs, muscles, &SceneMusclePair::muscles) != scene.muscle_pairs.end();
}

}  // namespace

bool may_add_effect(const Scene& scene, std::string_view effect) {
  return !has_effect(scene, effect) &&
         std::ranges::find(scene.exclusions, effect, &EffectExclusion::effect) == scene.exclusions.end();
}

void add_effect(Scene& scene, const AdvisedEffect& advised, const std::string& rule, const std::string& reason) {
  const EffectEntry& entry = *find_effect(advised.name);
  scene.effects.push_back({advised.name, Parameters(entry.parameters, advised.values, rule)});
  std::ranges::stable_sort(scene.effects, {}, [](const SceneEffect& effect) { return rank_of(effect.name); });
  scene.auto_effects.added.push_back({advised.name, rule, reason});
}

bool may_add_muscle_contact(const Scene& scene, MusclePair muscles) {
  return !scene.auto_effects.keeps_out_muscle_contact && !has_pair(scene, muscles);
}

void add_muscle_contact(Scene& scene, MusclePair muscles, const std::string& rule, const std::string& reason) {
  scene.muscle_pairs.push_back({muscles});
  std::ranges::sort(scene.muscle_pairs, {}, &SceneMusclePair::muscles);
  scene.auto_effects.added.push_back({name_of_muscle_contact(scene, muscles), rule, reason});
}

std::string name_of_muscle_contact(const Scene& scene, MusclePair muscles) {
  const auto name_of = [&](int muscle) { return scene.muscles[static_cast<std::size_t>(muscle)].body.name; };
  return fmt::format("muscle_contact {} {}", name_of(muscles.first), name_of(muscles.second));
}

void remove_added(Scene& scene, const std::string& name) {
  std::erase_if(scene.auto_effects.added, [&](const AddedEffect& added) { return added.effect == name; });
  std::erase_if(scene.effects, [&](const SceneEffect& effect) { return effect.name == name; });
  std::erase_if(scene.muscle_pairs,
                [&](const SceneMusclePair& pair) { return name_of_muscle_contact(scene, pair.muscles) == name; });
}

void add_advised_effects(Scene& scene, const std::function<void(int done, int total)>& report) {
  CheckOptions options;
  options.report = report;
  for (const Finding& finding : check_scene(scene, options)) {
    const std::string reason = fmt::format("{}: {}", finding.where, finding.what);
    // Several findings may ask for one effect: the first tells its parameters.
    if (finding.effect && may_add_effect(scene, finding.effect->name)) {
      add_effect(scene, *finding.effect, finding.id, reason);
    }
    if (finding.muscle_pair && may_add_muscle_contact(scene, *finding.muscle_pair)) {
      add_muscle_contact(scene, *finding.muscle_pair, finding.id, reason);
    }
  }
}

}  // namespace musclebench
