#pragma once

#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "core/scene/check/effect_reach.hpp"
#include "core/scene/check/scene_check.hpp"

namespace musclebench {

/// What the checker knows of one effect. The folder of an effect that it knows something of defines
/// `EffectChecks NAME_checks()` (`musclebench_effect(NAME ... CHECKS ...)`).
struct EffectChecks {
  std::vector<SceneRule> rules = {};
  /// What it acts on, in a scene that has it. Empty: it is none of contact.
  std::function<EffectReach(const Scene& scene, const SceneEffect& effect)> reach = {};
  /// Whether it moves a muscle that nothing else moves. Empty: it does not.
  std::function<bool(const SceneEffect& effect)> moves = {};
  bool carries_off = false;  ///< a muscle may get anywhere by it
};

struct EffectChecksSource {
  std::string_view effect;
  EffectChecks (*checks)();
};

/// Of the effects that a program is built with, in their order, as CMake lists them.
std::span<const EffectChecksSource> effect_checks_table();

/// Of the effect of that name, or nullptr.
const EffectChecks* find_checks(std::string_view effect);

/// What several effects are asked.
/// A course over time that begins after the run.
SceneRule late_start_rule(std::string_view effect);
/// A volume of a muscle whose surface is open.
SceneRule open_volume_rule(std::string_view effect);

}  // namespace musclebench
