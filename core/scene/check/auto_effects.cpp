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

void add_effect(const Finding& finding, Scene& scene) {
  const AdvisedEffect& advised = *finding.effect;
  // Several findings may ask for one effect: the first tells its parameters.
  if (has_effect(scene, advised.name)) return;
  if (std::ranges::find(scene.exclusions, advised.name, &EffectExclusion::effect) != scene.exclusions.end()) return;
  const EffectEntry& entry = *find_effect(advised.name);
  scene.effects.push_back({advised.name, Parameters(entry.parameters, advised.values, finding.id)});
  scene.auto_effects.added.push_back({advised.name, finding.id, fmt::format("{}: {}", finding.where, finding.what)});
}

void add_pair(const Finding& finding, Scene& scene) {
  if (scene.auto_effects.keeps_out_muscle_contact) return;
  const auto& [first, second] = *finding.muscle_pair;
  scene.muscle_pairs.push_back({*finding.muscle_pair});
  scene.auto_effects.added.push_back(
      {fmt::format("muscle_contact {} {}", scene.muscles[static_cast<std::size_t>(first)].body.name,
                   scene.muscles[static_cast<std::size_t>(second)].body.name),
       finding.id, fmt::format("{}: {}", finding.where, finding.what)});
}

}  // namespace

void add_advised_effects(Scene& scene, const std::function<void(int done, int total)>& report) {
  CheckOptions options;
  options.report = report;
  for (const Finding& finding : check_scene(scene, options)) {
    if (finding.effect) add_effect(finding, scene);
    if (finding.muscle_pair) add_pair(finding, scene);
  }
  std::ranges::stable_sort(scene.effects, {}, [](const SceneEffect& effect) { return rank_of(effect.name); });
  std::ranges::sort(scene.muscle_pairs, {}, &SceneMusclePair::muscles);
}

}  // namespace musclebench
