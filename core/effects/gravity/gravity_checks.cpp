#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

void find_no_acceleration(CheckContext& context, Findings& findings) {
  const SceneEffect* gravity = find_named(context.scene, "gravity");
  if (gravity == nullptr) return;
  for (const char* axis : {"x_m_per_s2", "y_m_per_s2", "z_m_per_s2"}) {
    if (gravity->parameters.number(axis) != 0) return;
  }
  findings.push_back(cannot_act(key_of("gravity"), "is 0 along all axes: it moves nothing"));
  findings.back().remove = {"[effects.gravity]"};
}

}  // namespace

EffectChecks gravity_checks() {
  return {.rules = {{.id = "zero_parameter", .look = find_no_acceleration}},
          .moves = [](const SceneEffect& /*effect*/) { return true; },
          .carries_off = true};
}

}  // namespace musclebench
