#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Coulomb friction on bones, as a limit on how far a node slides in a step (Macklin et al. 2014, "Unified
/// particle physics for real-time applications"): of the tangential displacement relative to the bone the part up to
/// coefficient times the push out of the bone is undone. A node in contact with several bones shares its friction among
/// them by their pushes, so that their order does not matter. Contacts that other stages find (faces, muscles) rub in
/// their ContactRowSolver.
std::unique_ptr<ContactStage> make_friction(const StageInput& input, const Parameters& parameters);
void set_friction(ContactProperties& contacts, const Parameters& parameters);
std::vector<ParameterSpec> friction_parameters();

}  // namespace musclebench
