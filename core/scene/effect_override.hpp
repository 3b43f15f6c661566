#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// What a user says of one effect besides scene and preset.
struct EffectOverride {
  std::string location;  ///< for messages: the option as it was written
  std::string name;
  bool is_removed = false;                            ///< else it is added, or some of its values are changed
  std::map<std::string, ParameterValue> values = {};  ///< what is not given stays as the scene has it
};

/// Changes `effects`, which stay in the order of the registry. Throws InputError where a name or a key is unknown, a
/// value is out of range, one effect is named twice, or one is removed that is not there.
void override_effects(const std::vector<EffectOverride>& overrides, std::vector<SceneEffect>& effects);

}  // namespace musclebench
