#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

void find_muscles_without_fibres(CheckContext& context, Findings& findings) {
  if (find_named(context.scene, "activation") == nullptr) return;
  for (const Muscle& muscle : context.scene.muscles) {
    if (has_fibres(muscle)) continue;
    findings.push_back(cannot_act(key_of("activation"), needs_fibres(muscle)));
    findings.back().add = {"fibres = \"between_attachments\""};
  }
}

}  // namespace

EffectChecks activation_checks() {
  return {.rules = {{.id = "no_fibres", .look = find_muscles_without_fibres}, late_start_rule("activation")},
          .moves = [](const SceneEffect& /*effect*/) { return true; }};
}

}  // namespace musclebench
