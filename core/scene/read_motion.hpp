#pragma once

#include <vector>

#include "core/base/parameters.hpp"
#include "core/scene/bone_motion.hpp"
#include "core/scene/scene_request.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

/// What may be changed of the motion of all bones that turn about one axis.
std::vector<ParameterSpec> motion_parameters();

/// The `[bone.motion]` of a `[[bone]]`, several `[[bone.motion]]`, or none. Throws InputError.
BoneMotion read_motion(const SceneRequest& request, const TomlTable& bone);

}  // namespace musclebench
