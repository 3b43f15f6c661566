#include <optional>

#include <fmt/format.h>

#include "core/effects/self_contact/self_contact.hpp"
#include "core/scene/check/compression.hpp"
#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

/// Whether the surface is as stiff against bending as the tissue under it: preset `standard` derives 1e4 rad/Nm, and
/// with 1e7 surfaces folded.
bool resists_bending(const Scene& scene) {
  constexpr double largest_compliance_rad_per_n_m = 1e5;
  const SceneEffect* bending = find_named(scene, "bending");
  return bending != nullptr && bending->parameters.number("compliance_rad_per_n_m") <= largest_compliance_rad_per_n_m;
}

void find_compressed_surfaces(CheckContext& context, Findings& findings) {
  constexpr const char* effect = "self_contact";
  // A surface buckles where it is compressed in itself, and the buckles of a sheet without thickness pass through each
  // other. Measured at full flexion of the hip without bending that resists: 0.2 to 7 % of the triangles, for ratios of
  // 0.6 to 0.91.
  constexpr double largest_ratio = 0.95;
  if (has_effect(context.scene, effect) || resists_bending(context.scene)) return;
  for (const Compression& found : compressions(context.scene, context.poses())) {
    if (found.edge_ratio > largest_ratio) continue;
    const double degrees = found.angle_rad * degrees_per_radian;
    findings.push_back(
        {.where = fmt::format("muscle '{}'", muscle_name(context.scene, found.muscle)),
         .what = fmt::format("one in twenty of its edges is shorter than {} of its length at rest when the bones are "
                             "turned by {:.2g} degrees (estimated): the surface buckles and may fold through itself",
                             percent(found.edge_ratio), degrees),
         .figures = {{"edge_ratio", found.edge_ratio}, {"angle_rad", found.angle_rad}},
         .add = {fmt::format("[effects.{}]", effect)},
         .effect = AdvisedEffect{effect}});
  }
}

void find_thick_self_contact(CheckContext& context, Findings& findings) {
  const SceneEffect* contact = find_named(context.scene, "self_contact");
  if (contact == nullptr) return;
  const double kept_m = contact->parameters.number("thickness_m");
  const std::optional<double> thickness_m = context.usual_thickness_m();
  // What is nearer at rest than a few times the distance does not count as a fold.
  if (!thickness_m || self_contact_rest_factor * kept_m <= *thickness_m) return;
  Finding& finding = findings.emplace_back(Finding{
      .kind = FindingKind::cannot_act,
      .where = "effects.self_contact.thickness_m",
      .what =
          fmt::format("parts nearer at rest than {:.0f} times {} never count as a fold, and a quarter of the muscle "
                      "is no thicker than {}: most of it is left out; take 0, a fifth of the mean edge",
                      self_contact_rest_factor, mm(kept_m), mm(*thickness_m))});
  finding.figures = {{"thickness_m", kept_m}, {"muscle_thickness_m", *thickness_m}};
}

}  // namespace

EffectChecks self_contact_checks() {
  return {.rules = {{.id = "thick_self_contact", .look = find_thick_self_contact, .needs_geometry = true},
                    {.id = "self_contact", .look = find_compressed_surfaces, .needs_geometry = true}},
          .reach = [](const Scene& /*scene*/, const SceneEffect& effect) {
            return EffectReach{.effect = effect.name, .itself = true};
          }};
}

}  // namespace musclebench
