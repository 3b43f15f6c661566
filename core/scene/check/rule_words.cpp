#include "core/scene/check/rule_words.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace musclebench {

const SceneEffect* find_named(const Scene& scene, std::string_view effect) {
  const auto found = std::ranges::find(scene.effects, effect, &SceneEffect::name);
  return found == scene.effects.end() ? nullptr : &*found;
}

bool is_given_by_scene(const SceneEffect& effect, std::string_view parameter) {
  return std::ranges::find(effect.own_keys, parameter) != effect.own_keys.end();
}

bool has_fibres(const Muscle& muscle) { return muscle.fibres_between_attachments || !muscle.fibres.empty(); }

std::string key_of(std::string_view effect, std::string_view parameter) {
  return parameter.empty() ? fmt::format("effects.{}", effect) : fmt::format("effects.{}.{}", effect, parameter);
}

Finding cannot_act(std::string where, std::string what) {
  return {.kind = FindingKind::cannot_act, .where = std::move(where), .what = std::move(what)};
}

std::string needs_fibres(const Muscle& muscle) {
  return fmt::format("needs fibres, and muscle '{}' has none", muscle.body.name);
}

const std::string& bone_name(const Scene& scene, std::size_t bone) { return scene.bones[bone].name; }

const std::string& muscle_name(const Scene& scene, std::size_t muscle) { return scene.muscles[muscle].body.name; }

std::string percent(double share) { return fmt::format("{:.{}f} %", 100 * share, share < 0.1 ? 1 : 0); }

std::string mm(double metres) { return fmt::format("{:.2g} mm", 1e3 * metres); }

}  // namespace musclebench
