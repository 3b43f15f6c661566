#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

void find_retinacula(CheckContext& context, Findings& findings) {
  const bool has = has_effect(context.scene, "retinaculum");
  if (has && context.scene.retinacula.empty()) {
    findings.push_back(cannot_act(key_of("retinaculum"), "has nothing to act on: the scene has no [[retinaculum]]"));
    findings.back().remove = {"[effects.retinaculum]"};
  }
  if (has || context.scene.retinacula.empty()) return;
  findings.push_back({.where = "retinaculum",
                      .what = "the scene has retinacula, but no effect holds tendons in them",
                      .add = {"[effects.retinaculum]"},
                      .effect = AdvisedEffect{"retinaculum"}});
}

}  // namespace

EffectChecks retinaculum_checks() { return {.rules = {{.id = "retinaculum", .look = find_retinacula}}}; }

}  // namespace musclebench
