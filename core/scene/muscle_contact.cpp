#include "core/scene/muscle_contact.hpp"

#include <utility>

#include "core/effects/effect_registry.hpp"
#include "core/pbd/muscle_contact_stage.hpp"

namespace musclebench {

std::unique_ptr<ContactStage> make_muscle_contact_stage(const Scene& scene, std::span<const double> inverse_masses,
                                                        MuscleContactDetectors detectors) {
  std::vector<MusclePair> pairs;
  std::vector<int> steps;
  for (const SceneMusclePair& pair : scene.muscle_pairs) {
    pairs.push_back(pair.muscles);
    steps.push_back(pair.response_steps.value_or(scene.response_steps));
  }
  MuscleContactResponse response(scene.muscle_mesh.triangles, {inverse_masses.begin(), inverse_masses.end()},
                                 PairSteps(scene.bodies(), std::move(pairs), std::move(steps)));
  for (const SceneEffect& effect : scene.effects) {
    const EffectEntry& entry = *find_effect(effect.name);
    if (entry.set_muscle_response) entry.set_muscle_response(response, effect.parameters);
  }
  return std::make_unique<MuscleContactStage>(std::move(detectors), std::move(response));
}

}  // namespace musclebench
