#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/scene/scene_warning.hpp"

namespace musclebench {

/// What the sizes and positions of the scene's meshes say, one line each: a unit that is likely not the metre, vertices
/// or whole meshes far outside the rest, a motion about a far point. Empty when all is plausible.
/// Each says which key of which table mends it.
std::vector<SceneWarning> size_warnings(const Scene& scene);

/// The same of a mesh alone: nothing where its size is that of a bone or a muscle in metres.
std::optional<std::string> size_warning(const TriangleMesh& mesh);

}  // namespace musclebench
