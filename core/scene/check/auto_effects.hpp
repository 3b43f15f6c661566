#pragma once

#include <functional>
#include <string>

#include "core/scene/read_scene.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Adds to the scene what `check_scene` finds lacking: effects with the parameters that the finding gives, and contact
/// of pairs of muscles. What the scene names stays as it is, what it keeps out stays out. Which backend detects
/// contacts changes nothing: runs of several backends have the same effects. `report`: rules done, of all.
void add_advised_effects(Scene& scene, const std::function<void(int done, int total)>& report = {});

/// A scene file of the same bones, muscles and attachments that names loop, effects and pairs of `scene` in full:
/// neither a preset nor `auto` is left in it, and relative paths are absolute. Reading it gives the same state to the
/// bit. `request`: what `scene` was read from.
std::string resolved_scene_text(const SceneRequest& request, const Scene& scene);

}  // namespace musclebench
