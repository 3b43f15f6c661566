#pragma once

#include <string>
#include <string_view>

#include "core/scene/check/finding.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// The effect of that name, or nullptr.
const SceneEffect* find_named(const Scene& scene, std::string_view effect);

/// By the scene itself and not by its preset.
bool is_given_by_scene(const SceneEffect& effect, std::string_view parameter);

bool has_fibres(const Muscle& muscle);

/// "effects.damping", "effects.damping.rate_per_s"
std::string key_of(std::string_view effect, std::string_view parameter = {});

Finding cannot_act(std::string where, std::string what);

/// "needs fibres, and muscle 'iliacus' has none"
std::string needs_fibres(const Muscle& muscle);

const std::string& bone_name(const Scene& scene, std::size_t bone);
const std::string& muscle_name(const Scene& scene, std::size_t muscle);

/// "0.5 %"
std::string percent(double share);
/// "0.12 mm"
std::string mm(double metres);

}  // namespace musclebench
