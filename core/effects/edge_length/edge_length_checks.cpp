#include <algorithm>

#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

void find_ignored_anisotropy(CheckContext& context, Findings& findings) {
  const SceneEffect* lengths = find_named(context.scene, "edge_length");
  const double exponent = lengths == nullptr ? 0 : lengths->parameters.number("anisotropy_exponent");
  // Presets give every scene the exponent; one that asks for it itself would see it.
  if (exponent == 0 || !is_given_by_scene(*lengths, "anisotropy_exponent")) return;
  for (const Muscle& muscle : context.scene.muscles) {
    if (has_fibres(muscle)) continue;
    Finding& finding =
        findings.emplace_back(cannot_act(key_of("edge_length", "anisotropy_exponent"), needs_fibres(muscle)));
    finding.figures = {{"anisotropy_exponent", exponent}};
    finding.add = {"fibres = \"between_attachments\""};
  }
}

void find_ignored_fibres(CheckContext& context, Findings& findings) {
  const SceneEffect* lengths = find_named(context.scene, "edge_length");
  if (lengths == nullptr || lengths->parameters.number("anisotropy_exponent") != 0) return;
  // With fibre_force edges that hold alike in all directions are what one wants: fibres hold along themselves.
  if (find_named(context.scene, "activation") != nullptr || find_named(context.scene, "fibre_force") != nullptr) return;
  if (std::ranges::none_of(context.scene.muscles, has_fibres) || context.scene.fibre_count > 0) return;
  Finding& finding = findings.emplace_back(
      cannot_act("muscle.fibres", "no effect uses the fibres: edge_length.anisotropy_exponent is 0"));
  finding.figures = {{"anisotropy_exponent", 0}};
  finding.remove = {"anisotropy_exponent = 0"};
}

void find_lacking_lengths(CheckContext& context, Findings& findings) {
  if (has_effect(context.scene, "edge_length")) return;
  // Activation gives every edge a length, too, by its angle to the fibres.
  if (has_effect(context.scene, "activation") && std::ranges::all_of(context.scene.muscles, has_fibres)) return;
  findings.push_back({.where = "muscle",
                      .what = "no effect holds its surface together",
                      .add = {"[effects.edge_length]"},
                      .effect = AdvisedEffect{"edge_length"}});
}

}  // namespace

EffectChecks edge_length_checks() {
  return {.rules = {{.id = "no_fibres", .look = find_ignored_anisotropy},
                    {.id = "ignored_fibres", .look = find_ignored_fibres},
                    {.id = "edge_length", .look = find_lacking_lengths}}};
}

}  // namespace musclebench
