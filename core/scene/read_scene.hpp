#pragma once

#include "core/scene/scene.hpp"
#include "core/scene/scene_request.hpp"

namespace musclebench {

/// Reads a scene with all its files. Throws InputError that names file, line and key.
Scene read_scene(const SceneRequest& request);

}  // namespace musclebench
