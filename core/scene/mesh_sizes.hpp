#pragma once

#include <vector>

#include "core/scene/scene.hpp"
#include "core/scene/scene_warning.hpp"

namespace musclebench {

/// What the sizes and positions of the scene's meshes say, one line each: a unit that is likely not the metre, vertices
/// or whole meshes far outside the rest, a motion about a far point. Empty when all is plausible.
std::vector<SceneWarning> size_warnings(const Scene& scene);

}  // namespace musclebench
