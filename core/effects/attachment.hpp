#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Bound nodes follow their bone: p = pose(rest position in the bone's frame). Their inverse mass is 0, so that no
/// other constraint moves them (Mueller et al. 2007, "Position based dynamics", section 3.6: attachments are nodes of
/// infinite mass).
std::unique_ptr<Effect> make_attachment(const EffectInput& input, const Parameters& parameters);
std::vector<ParameterSpec> attachment_parameters();

}  // namespace musclebench
