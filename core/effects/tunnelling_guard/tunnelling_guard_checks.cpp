#include <fmt/format.h>

#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"
#include "core/scene/check/step_against_thickness.hpp"

namespace musclebench {

namespace {

void find_ignored_guard_angle(CheckContext& context, Findings& findings) {
  const SceneEffect* guard = find_named(context.scene, "tunnelling_guard");
  if (guard == nullptr || guard->parameters.word("rule") == "angle" || !guard->parameters.given("angle_deg")) return;
  Finding& finding = findings.emplace_back(
      cannot_act(key_of("tunnelling_guard", "angle_deg"), "applies to rule 'angle' only, and the rule is 'crossing'"));
  finding.figures = {{"angle_deg", guard->parameters.number("angle_deg")}};
  finding.remove = {"angle_deg"};
}

void find_thin_bones(CheckContext& context, Findings& findings) {
  constexpr double least_share = 5e-3;  // of a bone's surface near a muscle; folds and slivers of a mesh are less
  if (has_effect(context.scene, "tunnelling_guard")) return;
  for (std::size_t bone = 0; bone < context.scene.bones.size(); ++bone) {
    const StepAgainstThickness found = step_against_thickness(context.scene, bone);
    if (found.thinner.share <= least_share) continue;
    findings.push_back(
        {.where = fmt::format("bone '{}'", bone_name(context.scene, bone)),
         .what = fmt::format("one step moves bone and muscle by up to {:.3g} mm relative to each other, but {} of the "
                             "bone's surface near the muscle is thinner (down to {:.2g} mm): nodes can pass through "
                             "the bone (more substeps also help)",
                             1e3 * found.step_m, percent(found.thinner.share), 1e3 * found.thinner.thinnest_m),
         .figures = {{"step_m", found.step_m},
                     {"thinner_share", found.thinner.share},
                     {"thinnest_m", found.thinner.thinnest_m}},
         .add = {"[effects.tunnelling_guard]"},
         .effect = AdvisedEffect{"tunnelling_guard"}});
  }
}

}  // namespace

EffectChecks tunnelling_guard_checks() {
  return {.rules = {{.id = "ignored_guard_angle", .look = find_ignored_guard_angle},
                    {.id = "tunnelling_guard", .look = find_thin_bones, .needs_geometry = true}},
          .reach = [](const Scene& scene, const SceneEffect& effect) {
            return EffectReach{.effect = effect.name, .nodes = !scene.bones.empty()};
          }};
}

}  // namespace musclebench
