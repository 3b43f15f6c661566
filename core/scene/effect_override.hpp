#pragma once

#include <vector>

#include "core/scene/scene.hpp"
#include "core/scene/scene_request.hpp"

namespace musclebench {

/// Changes `effects`, which stay in the order of the registry. Throws InputError where a name or a key is unknown, a
/// value is out of range, one effect is named twice, or one is removed that is not there.
void override_effects(const std::vector<EffectOverride>& overrides, std::vector<SceneEffect>& effects);

}  // namespace musclebench
