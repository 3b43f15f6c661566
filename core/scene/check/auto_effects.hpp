#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "core/scene/check/finding.hpp"
#include "core/scene/read_scene.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Whether an effect may be added: the scene neither names it nor keeps it out.
bool may_add_effect(const Scene& scene, std::string_view effect);
/// Adds the effect in its place among those of the scene, and says so in `auto_effects`.
void add_effect(Scene& scene, const AdvisedEffect& advised, const std::string& rule, const std::string& reason);

/// The same for contact between two muscles.
bool may_add_muscle_contact(const Scene& scene, MusclePair muscles);
void add_muscle_contact(Scene& scene, MusclePair muscles, const std::string& rule, const std::string& reason);
/// "muscle_contact NAME NAME"
std::string name_of_muscle_contact(const Scene& scene, MusclePair muscles);

/// Takes away what was added under that name.
void remove_added(Scene& scene, const std::string& name);

/// Adds to the scene what `check_scene` finds lacking: effects with the parameters that the finding gives, and contact
/// of pairs of muscles. What the scene names stays as it is, what it keeps out stays out. Which backend detects
/// contacts changes nothing: runs of several backends have the same effects. `report`: rules done, of all.
void add_advised_effects(Scene& scene, const std::function<void(int done, int total)>& report = {});

/// A scene file of the same bones, muscles and attachments that names loop, effects and pairs of `scene` in full:
/// neither a preset nor `auto` is left in it, and relative paths are absolute. Reading it gives the same state to the
/// bit. `request`: what `scene` was read from.
std::string resolved_scene_text(const SceneRequest& request, const Scene& scene);

}  // namespace musclebench
