#pragma once

#include <vector>

#include "core/base/parameters.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/scene_request.hpp"

namespace musclebench {

/// What may be changed of the motion of all bones that move.
std::vector<ParameterSpec> motion_parameters();

/// Reads a scene with all its files. Throws InputError that names file, line and key.
Scene read_scene(const SceneRequest& request);

}  // namespace musclebench
