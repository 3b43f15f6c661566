#include <fmt/format.h>

#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/pinch.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

void find_multi_bone_of_one(CheckContext& context, Findings& findings) {
  if (!has_effect(context.scene, "multi_bone") || context.scene.bones.size() > 1) return;
  findings.push_back(cannot_act(key_of("multi_bone"), "is for nodes in several bones, and the scene has one"));
  findings.back().remove = {"[effects.multi_bone]"};
}

void find_overruled_steps(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  if (!has_effect(scene, "multi_bone") || scene.response_steps_location.empty() || !scene.muscle_pairs.empty()) return;
  Finding& finding = findings.emplace_back(
      cannot_act("contact.steps", "multi_bone ignores it, and takes as many steps as leaving all bones needs"));
  finding.figures = {{"steps", static_cast<double>(scene.response_steps)}};
  finding.remove = {fmt::format("steps = {}", scene.response_steps)};
}

void find_pinches(CheckContext& context, Findings& findings) {
  if (has_effect(context.scene, "multi_bone") || context.scene.bones.size() < 2) return;
  // Squeezed to half, a muscle's two sides begin to be pushed by both bones.
  constexpr double most_room = 0.5;
  for (const Pinch& pinch : pinches(context.poses(), context.nearness(), context.thickness_m())) {
    if (pinch.room_m >= most_room * pinch.thickness_m) continue;
    findings.push_back({.where = fmt::format("bones '{}' and '{}'", bone_name(context.scene, pinch.first_bone),
                                             bone_name(context.scene, pinch.second_bone)),
                        .what = fmt::format(
                            "{} nodes come between them where the gap is narrower than the muscle is thick ({} for {}, "
                            "estimated): the pushes of the two bones add up",
                            pinch.nodes, mm(pinch.room_m), mm(pinch.thickness_m)),
                        .figures = {{"room_m", pinch.room_m},
                                    {"thickness_m", pinch.thickness_m},
                                    {"nodes", static_cast<double>(pinch.nodes)}},
                        .add = {"[effects.multi_bone]"},
                        .effect = AdvisedEffect{"multi_bone"}});
  }
}

}  // namespace

EffectChecks multi_bone_checks() {
  return {.rules = {{.id = "one_bone", .look = find_multi_bone_of_one},
                    {.id = "overruled_steps", .look = find_overruled_steps},
                    {.id = "multi_bone", .look = find_pinches, .needs_geometry = true}},
          .reach = [](const Scene& scene, const SceneEffect& effect) {
            return EffectReach{effect.name, scene.bones.size() > 1};
          }};
}

}  // namespace musclebench
