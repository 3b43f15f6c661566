#include "core/scene/check/effect_reach.hpp"

#include <algorithm>

namespace musclebench {

namespace {

bool has(const Scene& scene, std::string_view effect) {
  return std::ranges::find(scene.effects, effect, &SceneEffect::name) != scene.effects.end();
}

EffectReach passage_of(const Scene& scene, const SceneEffect& effect) {
  const bool bones = !scene.bones.empty();
  return {effect.name, bones, bones, scene.muscles.size() > 1, effect.parameters.flag("itself")};
}

/// What friction finds there: the contacts of all other effects.
EffectReach contacts_of(const Scene& scene, std::string_view name) {
  EffectReach reach{name, !scene.bones.empty(), has(scene, "surface_contact") && !scene.bones.empty(),
                    !scene.muscle_pairs.empty(), has(scene, "self_contact")};
  const auto passage = std::ranges::find(scene.effects, "no_passage", &SceneEffect::name);
  if (passage != scene.effects.end()) {
    const EffectReach more = passage_of(scene, *passage);
    reach.surface |= more.surface;
    reach.muscles |= more.muscles;
    reach.itself |= more.itself;
  }
  return reach;
}

}  // namespace

std::string EffectReach::text() const {
  std::vector<std::string> parts;
  if (nodes || surface) {
    parts.emplace_back(nodes && surface ? "nodes, faces and edges against bones"
                                        : (nodes ? "nodes against bones" : "faces and edges against bones"));
  }
  if (muscles) parts.emplace_back("muscles against each other");
  if (itself) parts.emplace_back("each muscle against itself");
  if (parts.empty()) return "nothing";
  std::string all = parts.front();
  for (std::size_t i = 1; i < parts.size(); ++i) all += "; " + parts[i];
  return all;
}

std::vector<EffectReach> effect_reaches(const Scene& scene) {
  const bool bones = !scene.bones.empty();
  std::vector<EffectReach> reaches;
  for (const SceneEffect& effect : scene.effects) {
    if (effect.name == "margin") reaches.push_back({effect.name, bones, bones && has(scene, "surface_contact")});
    if (effect.name == "multi_bone") reaches.push_back({effect.name, scene.bones.size() > 1});
    if (effect.name == "friction") reaches.push_back(contacts_of(scene, effect.name));
    if (effect.name == "self_contact") reaches.push_back({effect.name, false, false, false, true});
    if (effect.name == "surface_contact") reaches.push_back({effect.name, false, bones});
    if (effect.name == "tunnelling_guard") reaches.push_back({effect.name, bones});
    if (effect.name == "no_passage") reaches.push_back(passage_of(scene, effect));
  }
  return reaches;
}

}  // namespace musclebench
