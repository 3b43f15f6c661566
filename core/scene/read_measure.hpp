#pragma once

#include <optional>

#include "core/scene/read_scene.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

/// `[measure]`: what a run looks at beside the contacts. Reads it into `scene`, whose bones, muscles and loop have been
/// read. Throws InputError, or notes an obstacle, where the scene has no fibres that could be followed: no or several
/// bones turn, the motion has fewer than three frames, a muscle is not bound to two bones.
void read_measure(const SceneRequest& request, const std::optional<TomlTable>& table, Scene& scene);

}  // namespace musclebench
