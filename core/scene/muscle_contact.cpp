#include "core/scene/muscle_contact.hpp"

#include <utility>

#include "core/pbd/muscle_contact_stage.hpp"

namespace musclebench {

std::unique_ptr<ContactStage> make_muscle_contact_stage(const Scene& scene, std::span<const double> inverse_masses,
                                                        const ContactProperties& properties,
                                                        MuscleContactDetectors detectors) {
  std::vector<MusclePair> pairs;
  std::vector<int> steps;
  for (const SceneMusclePair& pair : scene.muscle_pairs) {
    pairs.push_back(pair.muscles);
    steps.push_back(pair.response_steps.value_or(scene.response_steps));
  }
  return std::make_unique<MuscleContactStage>(
      std::move(detectors), scene.muscle_mesh.triangles, PairSteps(scene.bodies(), std::move(pairs), std::move(steps)),
      ContactRowSolver({inverse_masses.begin(), inverse_masses.end()}, properties.friction_coefficient));
}

}  // namespace musclebench
