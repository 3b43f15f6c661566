#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

void find_two_volumes(CheckContext& context, Findings& findings) {
  if (!has_effect(context.scene, "volume") || !has_effect(context.scene, "local_volume")) return;
  findings.push_back(
      cannot_act(key_of("volume"), "adds nothing to local_volume, whose regions together are the whole muscle"));
  if (find_named(context.scene, "volume")->is_own) {
    findings.back().remove = {"[effects.volume]"};
  } else {
    findings.back().add = {"volume = false under [effects]"};
  }
}

void find_lacking_volume(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  if (has_effect(scene, "volume") || has_effect(scene, "local_volume")) return;
  for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
    if (!is_closed_muscle(scene, muscle)) return;  // nothing could keep it
  }
  findings.push_back({.where = scene.muscles.size() == 1 ? "muscle" : "muscles",
                      .what = "no effect keeps the volume ([effects.local_volume] keeps the volume of each region: a "
                              "squeezed end then does not inflate the other end)",
                      .add = {"[effects.volume]"},
                      .effect = AdvisedEffect{"volume"}});
}

}  // namespace

EffectChecks volume_checks() {
  return {.rules = {open_volume_rule("volume"),
                    {.id = "two_volumes", .look = find_two_volumes},
                    {.id = "volume", .look = find_lacking_volume, .needs_geometry = true}},
          .moves = [](const SceneEffect& effect) { return effect.parameters.number("pressure") != 1; }};
}

}  // namespace musclebench
