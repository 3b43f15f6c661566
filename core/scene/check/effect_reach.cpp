#include "core/scene/check/effect_reach.hpp"

#include "core/scene/check/effect_checks.hpp"

namespace musclebench {

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
  std::vector<EffectReach> reaches;
  for (const SceneEffect& effect : scene.effects) {
    const EffectChecks* checks = find_checks(effect.name);
    if (checks != nullptr && checks->reach) reaches.push_back(checks->reach(scene, effect));
  }
  return reaches;
}

}  // namespace musclebench
