#pragma once

#include "core/scene/scene.hpp"
#include "core/scene/scene_request.hpp"

namespace musclebench {

/// Reads a scene and all files that it names, repairs the meshes and checks every parameter. Lengths of the result are
/// in metres. Throws InputError that names file, line and key.
Scene read_scene(const SceneRequest& request);

}  // namespace musclebench
