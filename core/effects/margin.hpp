#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// A skin on the bones (paper, section IV-C): nodes that come closer than `thickness_m` are in contact, as deep as they
/// are in the skin, and the backend's own contacts are deeper by the skin. The distance is exact, whatever the backend:
/// only nodes near a bone are queried (ClearanceCache). Faces keep it with `surface_contact` (`set_margin`).
std::unique_ptr<ContactStage> make_margin(const StageInput& input, const Parameters& parameters);
void set_margin(ContactProperties& contacts, const Parameters& parameters);
std::vector<ParameterSpec> margin_parameters();

}  // namespace musclebench
