#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/effects/effect_registry.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh_repair/check_mesh.hpp"
#include "core/scene/check/coarse_cells.hpp"
#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/muscle_gap.hpp"
#include "core/scene/check/rule_words.hpp"
#include "core/scene/check/step_against_thickness.hpp"

namespace musclebench {

namespace {

void find_zeros(CheckContext& context, Findings& findings) {
  for (const SceneEffect& effect : context.scene.effects) {
    for (const std::string& parameter : find_effect(effect.name)->inert_at_zero) {
      if (effect.parameters.number(parameter) != 0) continue;
      Finding& finding = findings.emplace_back(
          cannot_act(key_of(effect.name, parameter), "is 0: the effect costs its time and changes nothing"));
      finding.figures = {{parameter, 0}};
      finding.remove = {fmt::format("[{}]", key_of(effect.name))};
    }
  }
}

/// Effects that need projection refuse a run that backtracks, whatever the backend.
void find_backtracking(CheckContext& context, Findings& findings) {
  if (context.scene.response != ResponseKind::backtrack) return;
  for (const SceneEffect& effect : context.scene.effects) {
    if (!find_effect(effect.name)->needs_projection) continue;
    Finding& finding = findings.emplace_back(Finding{.kind = FindingKind::contradiction,
                                                     .where = key_of(effect.name),
                                                     .what = "moves nodes by their depths, and [contact] has the "
                                                             "response 'backtrack': the scene can't be run"});
    finding.remove = {"response = \"backtrack\""};
  }
}

void find_all_bound(CheckContext& context, Findings& findings) {
  if (context.scene.attach_at_first_contact || context.free_node_count() > 0) return;
  findings.push_back(cannot_act("attachment",
                                "all nodes are bound to bones: effects and contacts cannot move any node; outline "
                                "smaller areas"));
}

void find_foreign_fibres(CheckContext& context, Findings& findings) {
  for (const Muscle& muscle : context.scene.muscles) {
    if (muscle.fibres.empty()) continue;
    Eigen::AlignedBox3d box = bounding_box(context.scene.vertices_of(muscle.body));
    const double slack_m = 0.1 * box.diagonal().norm();  // fibres of a muscle end at its bones, a little outside
    const auto without_length = std::ranges::count_if(
        muscle.fibres, [](const FibreSegment& fibre) { return !((fibre.end - fibre.start).squaredNorm() > 0); });
    const auto outside = std::ranges::count_if(muscle.fibres, [&](const FibreSegment& fibre) {
      return box.squaredExteriorDistance(Vec3(0.5 * (fibre.start + fibre.end))) > slack_m * slack_m;
    });
    const auto share_of = [&](auto count) {
      return static_cast<double>(count) / static_cast<double>(muscle.fibres.size());
    };
    const std::string where = fmt::format("muscle '{}', fibres", muscle.body.name);
    constexpr double least_share = 0.5;
    if (share_of(without_length) > least_share) {
      findings.push_back({.kind = FindingKind::contradiction,
                          .where = where,
                          .what = fmt::format("{:.0f} % of their segments have no length, and so no direction; check "
                                              "the file",
                                              100 * share_of(without_length)),
                          .figures = {{"without_length_share", share_of(without_length)}}});
    } else if (share_of(outside) > least_share) {
      findings.push_back({.kind = FindingKind::contradiction,
                          .where = where,
                          .what = fmt::format("{:.0f} % of their segments lie outside the muscle's box: they are "
                                              "another muscle's, or in another unit; check the file and the name "
                                              "after '#'",
                                              100 * share_of(outside)),
                          .figures = {{"outside_share", share_of(outside)}}});
    }
  }
}

void find_standstill(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  const auto leaves_rest = [](const BoneRotation& rotation) {
    return std::ranges::any_of(rotation.angles_rad, [](double angle) { return angle != 0; });
  };
  for (const BoneMotion& motion : scene.motions) {
    if (std::ranges::any_of(motion.rotations, leaves_rest)) return;
  }
  if (std::ranges::any_of(scene.muscles, [](const Muscle& muscle) { return !muscle.velocity_m_per_s.isZero(0); }))
    return;
  const bool moves = std::ranges::any_of(scene.effects, [](const SceneEffect& effect) {
    const EffectChecks* checks = find_checks(effect.name);
    return checks != nullptr && checks->moves && checks->moves(effect);
  });
  if (moves) return;
  findings.push_back(cannot_act("bone.motion",
                                "no bone moves, and neither gravity nor active fibres move the muscle: "
                                "nothing changes except overlaps at rest"));
}

/// Of a scene on which nothing is added that it could keep out.
void find_idle_exclusions(CheckContext& context, Findings& findings) {
  if (context.scene.auto_effects.wanted) return;
  for (const EffectExclusion& exclusion : context.scene.exclusions) {
    if (exclusion.is_of_preset) continue;
    findings.push_back(cannot_act(key_of(exclusion.effect), "is removed, but the preset does not have it"));
    findings.back().remove = {fmt::format("{} = false", exclusion.effect)};
  }
}

/// A node that two areas claim belongs to the first.
void find_claimed_attachments(CheckContext& context, Findings& findings) {
  std::set<int> claimed;
  for (const Attachment& attachment : context.scene.attachments) {
    const std::size_t before = claimed.size();
    claimed.insert(attachment.nodes.begin(), attachment.nodes.end());
    if (attachment.nodes.empty() || claimed.size() > before) continue;
    findings.push_back(
        cannot_act(fmt::format("attachment '{}'", attachment.name),
                   fmt::format("all of its {} nodes belong to earlier attachments already", attachment.nodes.size())));
    findings.back().figures = {{"nodes", static_cast<double>(attachment.nodes.size())}};
  }
}

/// Whether an effect does, whatever pairs there are.
bool keeps_muscles_apart(const Scene& scene) {
  return std::ranges::any_of(scene.effects, [](const SceneEffect& effect) {
    return std::ranges::find(find_effect(effect.name)->remedies, Requirement::muscle_passage, &Remedy::requirement) !=
           find_effect(effect.name)->remedies.end();
  });
}

void find_touching_muscles(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  if (scene.muscles.size() < 2 || keeps_muscles_apart(scene)) return;
  const double mean_edge_m = check_mesh(scene.muscle_mesh).mean_edge_m;
  for (const MuscleGap& gap : muscle_gaps(scene, context.poses(), mean_edge_m)) {
    if (std::ranges::find(scene.muscle_pairs, gap.muscles, &SceneMusclePair::muscles) != scene.muscle_pairs.end()) {
      continue;
    }
    // Nearer than an edge at rest they touch as soon as they move; later only what overlaps is told from the estimate.
    const bool at_rest = gap.rest_m < mean_edge_m;
    if (!at_rest && gap.least_m >= 0) continue;
    const auto first = static_cast<std::size_t>(gap.muscles.first);
    const auto second = static_cast<std::size_t>(gap.muscles.second);
    const std::string what =
        gap.rest_m < 0 ? fmt::format("overlap at rest by {} ({} nodes)", mm(-gap.rest_m), gap.rest_nodes_inside)
        : at_rest      ? fmt::format("are {} apart at rest", mm(gap.rest_m))
                       : fmt::format("would overlap by {} when the bones are turned by {:.0f} degrees (estimated)",
                                     mm(-gap.least_m), gap.least_angle_rad * degrees_per_radian);
    Finding& finding = findings.emplace_back(
        Finding{.where = fmt::format("muscles '{}' and '{}'", muscle_name(scene, first), muscle_name(scene, second)),
                .what = what + ", and nothing keeps them apart",
                .figures = {{"rest_gap_m", gap.rest_m}, {"least_gap_m", gap.least_m}}});
    if (!is_closed_muscle(scene, first) || !is_closed_muscle(scene, second)) {
      finding.what += " (contact between muscles needs closed surfaces)";
      continue;
    }
    finding.add = {"[[pair]]",
                   fmt::format("muscles = [\"{}\", \"{}\"]", muscle_name(scene, first), muscle_name(scene, second))};
    finding.muscle_pair = gap.muscles;
  }
}

void find_coarse_cells(CheckContext& context, Findings& findings) {
  for (const CoarseCells& coarse : coarse_cells(context)) {
    const BoneCells& cells = context.options.cells[coarse.bone];
    Finding& finding = findings.emplace_back(Finding{
        .where = fmt::format("bone '{}', backend '{}'", bone_name(context.scene, coarse.bone), cells.backend),
        .what = fmt::format("cells of {} make distances wrong by up to {}, and {} of the free nodes are "
                            "closer to the bone at rest (down to {}): these nodes may count as inside; take "
                            "finer cells{}",
                            mm(cells.cell_m), mm(cells.error_m), percent(coarse.nodes_share), mm(coarse.rest_gap_m),
                            cells.parameter.empty() ? "" : fmt::format(" (--param {}=...)", cells.parameter))});
    finding.figures = {{"cell_m", cells.cell_m},
                       {"error_m", cells.error_m},
                       {"nodes_share", coarse.nodes_share},
                       {"rest_gap_m", coarse.rest_gap_m}};
  }
}

/// A plate of one or two cells has its middle nearer to its faces than a field errs at kinks.
void find_features_thinner_than_cells(CheckContext& context, Findings& findings) {
  constexpr double least_share = 5e-3;  // of a bone's surface near a muscle; folds and slivers of a mesh are less
  for (std::size_t bone = 0; bone < context.options.cells.size(); ++bone) {
    const BoneCells& cells = context.options.cells[bone];
    if (!cells.misses || !(cells.cell_m > 0)) continue;
    const ThinShare thin = share_thinner_than(
        2 * cells.cell_m, sample_thickness(context.scene.bones[bone], box_near_muscles(context.scene)));
    if (thin.share <= least_share) continue;
    findings.push_back(
        {.where = fmt::format("bone '{}', backend '{}'", bone_name(context.scene, bone), cells.backend),
         .what = fmt::format("{} of its surface near the muscle is thinner than two cells of {} (down to {}): the "
                             "backend may miss nodes in it; take finer cells{}",
                             percent(thin.share), mm(cells.cell_m), mm(thin.thinnest_m),
                             cells.parameter.empty() ? "" : fmt::format(" (--param {}=...)", cells.parameter)),
         .figures = {{"cell_m", cells.cell_m}, {"thinner_share", thin.share}, {"thinnest_m", thin.thinnest_m}}});
  }
}

/// Whether a muscle may come where no pose of the bones alone would bring it.
bool may_fly(const Scene& scene) {
  return std::ranges::any_of(scene.muscles, [](const Muscle& muscle) { return !muscle.velocity_m_per_s.isZero(0); }) ||
         std::ranges::any_of(scene.effects, [](const SceneEffect& effect) {
           const EffectChecks* checks = find_checks(effect.name);
           return checks != nullptr && checks->carries_off;
         });
}

void find_contact_out_of_reach(CheckContext& context, Findings& findings) {
  std::vector<EffectReach> of_bones = effect_reaches(context.scene);
  std::erase_if(of_bones, [](const EffectReach& reach) {
    return (!reach.nodes && !reach.surface) || reach.muscles || reach.itself;
  });
  if (of_bones.empty() || may_fly(context.scene)) return;
  const bool near =
      std::ranges::any_of(context.nearness(), [](const BoneNearness& bone) { return !bone.near.empty(); });
  if (near) return;
  for (const EffectReach& reach : of_bones) {
    findings.push_back(cannot_act(
        key_of(reach.effect), "no bone comes nearer to a muscle than the muscle is thick, at any pose (estimated)"));
    findings.back().remove = {fmt::format("[{}]", key_of(reach.effect))};
  }
}

}  // namespace

const std::vector<SceneRule>& general_rules() {
  static const std::vector<SceneRule> rules = {
      {.id = "zero_parameter", .look = find_zeros},
      {.id = "backtracking", .look = find_backtracking},
      {.id = "all_bound", .look = find_all_bound},
      {.id = "foreign_fibres", .look = find_foreign_fibres},
      {.id = "standstill", .look = find_standstill},
      {.id = "idle_exclusion", .look = find_idle_exclusions},
      {.id = "claimed_attachment", .look = find_claimed_attachments},
      {.id = "out_of_reach", .look = find_contact_out_of_reach, .needs_geometry = true},
      {.id = "muscle_contact", .look = find_touching_muscles, .needs_geometry = true},
      {.id = "grid_cells", .look = find_coarse_cells, .needs_geometry = true},
      {.id = "feature_thinner_than_cell", .look = find_features_thinner_than_cells, .needs_geometry = true},
  };
  return rules;
}

}  // namespace musclebench
