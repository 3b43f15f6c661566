#include "core/scene/check/effect_checks.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

struct NamedChecks {
  std::string_view effect;
  EffectChecks checks;
};

const std::vector<NamedChecks>& all_checks() {
  static const std::vector<NamedChecks> all = [] {
    std::vector<NamedChecks> made;
    for (const EffectChecksSource& source : effect_checks_table()) made.push_back({source.effect, source.checks()});
    return made;
  }();
  return all;
}

}  // namespace

const EffectChecks* find_checks(std::string_view effect) {
  const auto found = std::ranges::find(all_checks(), effect, &NamedChecks::effect);
  return found == all_checks().end() ? nullptr : &found->checks;
}

SceneRule late_start_rule(std::string_view effect) {
  return {"late_activation", [effect](CheckContext& context, Findings& findings) {
            const LoopParameters& loop = context.scene.loop;
            const SceneEffect* named = find_named(context.scene, effect);
            if (named == nullptr) return;
            const double start_s = named->parameters.number("start_s");
            const double end_s = loop.time_s(loop.frames, loop.substeps);
            if (start_s < end_s) return;
            Finding& finding = findings.emplace_back(
                cannot_act(key_of(effect, "start_s"),
                           fmt::format("begins at {:.4g} s, and the run ends at {:.4g} s", start_s, end_s)));
            finding.figures = {{"start_s", start_s}, {"end_s", end_s}};
          }};
}

SceneRule open_volume_rule(std::string_view effect) {
  return {"open_volume", [effect](CheckContext& context, Findings& findings) {
            if (!has_effect(context.scene, effect)) return;
            for (std::size_t i = 0; i < context.scene.muscles.size(); ++i) {
              if (is_closed_muscle(context.scene, i)) continue;
              findings.push_back(cannot_act(
                  key_of(effect),
                  fmt::format("has no meaning for muscle '{}', whose surface is open: close it (`musclebench "
                              "check` counts its boundary edges)",
                              muscle_name(context.scene, i))));
              findings.back().remove = {fmt::format("[{}]", key_of(effect))};
            }
          }};
}

}  // namespace musclebench
