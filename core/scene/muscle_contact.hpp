#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/contact/contact_properties.hpp"
#include "core/contact/muscle_contact.hpp"
#include "core/pbd/contact_stage.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

using MuscleContactDetectors = std::vector<std::unique_ptr<MuscleContactDetector>>;

/// Contact between the scene's muscles. `detectors`, at least one, see to all `muscle_pairs` of the scene.
/// `inverse_masses`: by node, 1/kg.
std::unique_ptr<ContactStage> make_muscle_contact_stage(const Scene& scene, std::span<const double> inverse_masses,
                                                        const ContactProperties& properties,
                                                        MuscleContactDetectors detectors);

}  // namespace musclebench
