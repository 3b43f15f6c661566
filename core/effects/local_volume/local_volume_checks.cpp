#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

EffectChecks local_volume_checks() {
  return {.rules = {open_volume_rule("local_volume")},
          .moves = [](const SceneEffect& effect) { return effect.parameters.number("pressure") != 1; }};
}

}  // namespace musclebench
