#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

/// It acts on what other effects find, beside nodes on bones and muscles that touch.
EffectReach reach_of_friction(const Scene& scene, const SceneEffect& friction) {
  EffectReach reach{friction.name, !scene.bones.empty(), false, !scene.muscle_pairs.empty()};
  for (const SceneEffect& other : scene.effects) {
    const EffectChecks* checks = find_checks(other.name);
    if (other.name == friction.name || checks == nullptr || !checks->reach) continue;
    const EffectReach found = checks->reach(scene, other);
    reach.surface |= found.surface;
    reach.muscles |= found.muscles;
    reach.itself |= found.itself;
  }
  return reach;
}

}  // namespace

EffectChecks friction_checks() { return {.reach = reach_of_friction}; }

}  // namespace musclebench
