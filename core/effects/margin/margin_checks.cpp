#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/scene/check/coarse_cells.hpp"
#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

void find_contacts_without_margin(CheckContext& context, Findings& findings) {
  const auto leaves_out = [&](std::string what) {
    findings.push_back({.kind = FindingKind::acts_in_part, .where = key_of("margin"), .what = std::move(what)});
  };
  if (!has_effect(context.scene, "margin")) return;
  if (has_effect(context.scene, "self_contact")) {
    leaves_out("acts on bones only: self_contact has its own thickness");
  }
  if (!context.scene.muscle_pairs.empty()) leaves_out("acts on bones only: it keeps no distance between muscles");
}

void find_thick_margin(CheckContext& context, Findings& findings) {
  const SceneEffect* margin = find_named(context.scene, "margin");
  if (margin == nullptr) return;
  const double margin_m = margin->parameters.number("thickness_m");
  const std::optional<double> thickness_m = context.usual_thickness_m();
  if (!thickness_m || margin_m <= *thickness_m) return;
  Finding& finding = findings.emplace_back(
      Finding{.kind = FindingKind::contradiction,
              .where = "effects.margin.thickness_m",
              .what = fmt::format("a skin of {} on the bones is thicker than a quarter of the muscle ({}): between two "
                                  "bones two skins leave it no room; take a millimetre or less",
                                  mm(margin_m), mm(*thickness_m))});
  finding.figures = {{"margin_m", margin_m}, {"muscle_thickness_m", *thickness_m}};
}

/// Cells may miss what lies in a layer on the bone.
void find_missed_layers(CheckContext& context, Findings& findings) {
  if (has_effect(context.scene, "margin")) return;
  for (const CoarseCells& coarse : coarse_cells(context)) {
    const BoneCells& cells = context.options.cells[coarse.bone];
    if (!cells.misses) continue;
    findings.push_back(
        {.where = fmt::format("bone '{}'", bone_name(context.scene, coarse.bone)),
         .what = fmt::format("backend '{}' may miss nodes that are nearer to it than {}: finer cells do, or "
                             "a margin, which keeps nodes out of that layer",
                             cells.backend, mm(cells.error_m)),
         .figures = {{"error_m", cells.error_m}},
         .add = {"[effects.margin]", fmt::format("thickness_m = {:.2g}", cells.error_m)}});
  }
}

EffectReach reach_of_margin(const Scene& scene, const SceneEffect& effect) {
  const bool has_bones = !scene.bones.empty();
  return {effect.name, has_bones, has_bones && has_effect(scene, "surface_contact")};
}

}  // namespace

EffectChecks margin_checks() {
  return {.rules = {{.id = "partial_effect", .look = find_contacts_without_margin},
                    {.id = "thick_margin", .look = find_thick_margin, .needs_geometry = true},
                    {.id = "margin", .look = find_missed_layers, .needs_geometry = true}},
          .reach = reach_of_margin};
}

}  // namespace musclebench
