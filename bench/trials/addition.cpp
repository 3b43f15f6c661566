#include "bench/trials/addition.hpp"

#include <algorithm>
#include <iterator>

#include "core/effects/effect_registry.hpp"
#include "core/scene/check/auto_effects.hpp"
#include "core/scene/check/scene_check.hpp"

namespace musclebench {

namespace {

/// Closed muscles that may touch and do not yet.
std::vector<MusclePair> all_pairs(const Scene& scene) {
  std::vector<int> closed;
  for (int muscle = 0; muscle < static_cast<int>(scene.muscles.size()); ++muscle) {
    if (is_closed_muscle(scene, static_cast<std::size_t>(muscle))) closed.push_back(muscle);
  }
  std::vector<MusclePair> pairs;
  for (std::size_t first = 0; first < closed.size(); ++first) {
    for (std::size_t second = first + 1; second < closed.size(); ++second) {
      const MusclePair pair{closed[first], closed[second]};
      if (may_add_muscle_contact(scene, pair)) pairs.push_back(pair);
    }
  }
  return pairs;
}

Addition contact_of(const Scene& scene, std::vector<MusclePair> pairs, const std::string& name_of_several) {
  std::string name = pairs.size() == 1 ? name_of_muscle_contact(scene, pairs.front()) : name_of_several;
  return {std::move(name), {}, std::move(pairs)};
}

void append_contacts(const Scene& scene, const std::vector<Finding>& advised, std::vector<Addition>& additions) {
  std::vector<MusclePair> expected;
  for (const Finding& finding : advised) {
    if (finding.muscle_pair && may_add_muscle_contact(scene, *finding.muscle_pair)) {
      expected.push_back(*finding.muscle_pair);
    }
  }
  const std::vector<MusclePair> all = all_pairs(scene);
  if (!expected.empty()) additions.push_back(contact_of(scene, expected, "contact between muscles that meet"));
  if (all.size() > expected.size()) additions.push_back(contact_of(scene, all, "contact between all muscles"));
}

/// Nothing where it is none. Fibres pull only where they are asked for: that is no way to mend something else.
const Remedy* remedy_for(const EffectEntry& entry, Requirement requirement) {
  for (const Remedy& remedy : entry.remedies) {
    const bool is_any = requirement == Requirement::trusted_run && remedy.requirement != Requirement::taut_fibres;
    if (is_any || remedy.requirement == requirement) return &remedy;
  }
  return nullptr;
}

}  // namespace

std::vector<Addition> additions_for(const Scene& scene, Requirement requirement, const std::vector<Finding>& advised) {
  std::vector<Addition> additions;
  const bool is_about_muscles = requirement == Requirement::muscle_passage ||
                                requirement == Requirement::muscle_depth || requirement == Requirement::trusted_run;
  if (is_about_muscles) append_contacts(scene, advised, additions);
  std::vector<Addition> others;
  for (const EffectEntry& entry : effect_registry()) {
    const Remedy* remedy = remedy_for(entry, requirement);
    if (remedy == nullptr || !may_add_effect(scene, entry.name)) continue;
    const auto rule = std::ranges::find_if(
        advised, [&](const Finding& finding) { return finding.effect && finding.effect->name == entry.name; });
    if (rule != advised.end()) {
      additions.push_back({entry.name, rule->effect});
    } else {
      others.push_back({entry.name, AdvisedEffect{entry.name, remedy->values}});
    }
  }
  std::ranges::move(others, std::back_inserter(additions));
  return additions;
}

void add(Scene& scene, const Addition& addition, const std::string& rule, const std::string& reason) {
  if (addition.effect) add_effect(scene, *addition.effect, rule, reason);
  for (const MusclePair& pair : addition.pairs) add_muscle_contact(scene, pair, rule, reason);
}

Scene with_all_additions(const Scene& scene) {
  Scene widest = scene;
  for (const Addition& addition : additions_for(scene, Requirement::trusted_run, {})) {
    add(widest, addition, "any", "");
  }
  return widest;
}

std::vector<Finding> quick_findings(const Scene& scene) {
  CheckOptions options;
  options.only_quick = true;
  return check_scene(scene, options);
}

std::string refusal_by_rules(const Scene& with, const std::vector<Finding>& without) {
  for (const Finding& finding : quick_findings(with)) {
    const bool refuses = finding.kind == FindingKind::cannot_act || finding.kind == FindingKind::contradiction;
    const bool is_new = std::ranges::none_of(
        without, [&](const Finding& known) { return known.id == finding.id && known.where == finding.where; });
    if (refuses && is_new) return finding.where + " " + finding.what;
  }
  return {};
}

}  // namespace musclebench
