#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/base/percentile.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/effects/no_passage/passage_overlaps.hpp"
#include "core/effects/self_contact.hpp"
#include "core/mesh_repair/check_mesh.hpp"
#include "core/scene/check/compression.hpp"
#include "core/scene/check/muscle_gap.hpp"
#include "core/scene/check/pinch.hpp"
#include "core/scene/check/ridge_depth.hpp"
#include "core/scene/check/scene_check.hpp"
#include "core/scene/check/step_against_thickness.hpp"

namespace musclebench {

namespace {

std::string percent(double share) { return fmt::format("{:.{}f} %", 100 * share, share < 0.1 ? 1 : 0); }
std::string mm(double metres) { return fmt::format("{:.2g} mm", 1e3 * metres); }

const std::string& bone_name(const Scene& scene, std::size_t bone) { return scene.bones[bone].name; }
const std::string& muscle_name(const Scene& scene, std::size_t muscle) { return scene.muscles[muscle].body.name; }

void find_lacking_volume(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  if (has_effect(scene, "volume") || has_effect(scene, "local_volume")) return;
  for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
    if (!is_closed_muscle(scene, muscle)) return;  // nothing could keep it
  }
  findings.push_back({.where = scene.muscles.size() == 1 ? "muscle" : "muscles",
                      .what = "no effect keeps the volume ([effects.local_volume] keeps the volume of each region: a "
                              "squeezed end then does not inflate the other end)",
                      .add = {"[effects.volume]"},
                      .effect = AdvisedEffect{"volume"}});
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

void find_ridges(CheckContext& context, Findings& findings) {
  constexpr double least_m = 1e-4;  // 0.1 mm: below it contacts of a muscle count as exact
  const Scene& scene = context.scene;
  if (has_effect(scene, "surface_contact")) return;
  std::vector<std::optional<std::pair<std::size_t, RidgeDepth>>> deepest(scene.muscles.size());  // bone and depth
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    for (const RidgeDepth& ridge : ridge_depths(scene, bone, context.poses(), context.nearness()[bone])) {
      auto& of_muscle = deepest[ridge.muscle];
      if (ridge.p99_m > least_m && (!of_muscle || ridge.largest_m > of_muscle->second.largest_m)) {
        of_muscle = {bone, ridge};
      }
    }
  }
  for (const auto& found : deepest) {
    if (!found) continue;
    const auto& [bone, ridge] = *found;
    findings.push_back(
        {.where = fmt::format("muscle '{}', bone '{}'", muscle_name(scene, ridge.muscle), bone_name(scene, bone)),
         .what =
             fmt::format("the muscle's mesh is too coarse for ridges of the bone: a ridge can cut up to {} deep into "
                         "a face whose nodes are all outside, with edges {} long (estimated; at 99 % of {} "
                         "points less than {})",
                         mm(ridge.largest_m), mm(ridge.edge_m), ridge.samples, mm(ridge.p99_m)),
         .figures = {{"cut_depth_m", ridge.largest_m}, {"cut_depth_p99_m", ridge.p99_m}, {"edge_m", ridge.edge_m}},
         .add = {"[effects.surface_contact]"},
         .effect = AdvisedEffect{"surface_contact"}});
  }
}

void find_pinches(CheckContext& context, Findings& findings) {
  if (has_effect(context.scene, "multi_bone") || context.scene.bones.size() < 2) return;
  // Squeezed to half, a muscle's two sides begin to be pushed by both bones.
  constexpr double most_room = 0.5;
  for (const Pinch& pinch : pinches(context.poses(), context.nearness(), context.thickness_m())) {
    if (pinch.room_m >= most_room * pinch.thickness_m) continue;
    findings.push_back({.where = fmt::format("bones '{}' and '{}'", bone_name(context.scene, pinch.first_bone),
                                             bone_name(context.scene, pinch.second_bone)),
                        .what = fmt::format(
                            "{} nodes come between them where the gap is narrower than the muscle is thick ({} for {}, "
                            "estimated): the pushes of the two bones add up",
                            pinch.nodes, mm(pinch.room_m), mm(pinch.thickness_m)),
                        .figures = {{"room_m", pinch.room_m},
                                    {"thickness_m", pinch.thickness_m},
                                    {"nodes", static_cast<double>(pinch.nodes)}},
                        .add = {"[effects.multi_bone]"},
                        .effect = AdvisedEffect{"multi_bone"}});
  }
}

void find_touching_muscles(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  if (scene.muscles.size() < 2 || has_effect(scene, "no_passage")) return;
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

/// What goes through each other as the run begins; which bones lie where then, the motion says.
void find_passed_at_start(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  const auto effect = std::ranges::find(scene.effects, "no_passage", &SceneEffect::name);
  if (effect == scene.effects.end()) return;
  std::vector<RigidMotion> poses;
  scene.poses_at(0, poses);
  const std::vector<Body> bodies = scene.bodies();
  // By a muscle, and a bone or, behind all bones, the other muscle.
  std::map<std::pair<std::size_t, std::size_t>, std::set<std::size_t>> triangles;
  for (const TrianglePair& overlap : overlaps_at_start(scene.muscle_mesh, bodies, scene.bones, scene.bound_nodes(),
                                                       poses, effect->parameters.number("gap_m"))) {
    const auto muscle_of = [&](std::size_t t) { return body_of(bodies, scene.muscle_mesh.triangles[t][0]); };
    const std::size_t collider =
        overlap.bone >= 0 ? static_cast<std::size_t>(overlap.bone) : scene.bones.size() + muscle_of(overlap.other);
    triangles[{muscle_of(overlap.triangle), collider}].insert(overlap.triangle);
  }
  for (const auto& [surfaces, passed] : triangles) {
    const auto [muscle, collider] = surfaces;
    const std::size_t other = collider - scene.bones.size();  // where it is a muscle
    const std::string through = collider < scene.bones.size() ? fmt::format("bone '{}'", bone_name(scene, collider))
                                : other == muscle             ? "itself"
                                                              : fmt::format("muscle '{}'", muscle_name(scene, other));
    findings.push_back(
        {.kind = FindingKind::acts_in_part,
         .where = fmt::format("effects.no_passage, muscle '{}'", muscle_name(scene, muscle)),
         .what = fmt::format("{} of its triangles go through {} as the run begins: their nodes are not held apart from "
                             "it until they are free; place the meshes apart, or let contacts move the muscle out "
                             "before the first frame with settle_substeps",
                             passed.size(), through),
         .figures = {{"triangles", static_cast<double>(passed.size())}}});
  }
}

/// Whether the surface is as stiff against bending as the tissue under it: preset `standard` derives 1e4 rad/Nm, and
/// with 1e7 surfaces folded.
bool resists_bending(const Scene& scene) {
  constexpr double largest_compliance_rad_per_n_m = 1e5;
  const auto bending = std::ranges::find(scene.effects, "bending", &SceneEffect::name);
  return bending != scene.effects.end() &&
         bending->parameters.number("compliance_rad_per_n_m") <= largest_compliance_rad_per_n_m;
}

void find_compressed_surfaces(CheckContext& context, Findings& findings) {
  constexpr const char* effect = "self_contact";
  // A surface buckles where it is compressed in itself, and the buckles of a sheet without thickness pass through each
  // other. Measured at full flexion of the hip without bending that resists: 0.2 to 7 % of the triangles, for ratios of
  // 0.6 to 0.91.
  constexpr double largest_ratio = 0.95;
  if (find_effect(effect) == nullptr || has_effect(context.scene, effect) || resists_bending(context.scene)) return;
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

void find_coarse_cells(CheckContext& context, Findings& findings) {
  constexpr double least_share = 0.01;  // of the free nodes; below it what they do moves no figure of a run
  for (std::size_t bone = 0; bone < context.options.cells.size(); ++bone) {
    const BoneCells& cells = context.options.cells[bone];
    if (!(cells.error_m > 0)) continue;
    const BoneNearness& nearness = context.nearness()[bone];
    const auto inside_error = std::ranges::count_if(
        nearness.rest_distances_m, [&](double distance_m) { return distance_m > 0 && distance_m < cells.error_m; });
    const double share = static_cast<double>(inside_error) / static_cast<double>(context.free_node_count());
    if (share <= least_share) continue;
    Finding& finding = findings.emplace_back(
        Finding{.where = fmt::format("bone '{}', backend '{}'", bone_name(context.scene, bone), cells.backend),
                .what = fmt::format("cells of {} make distances wrong by up to {}, and {} of the free nodes are "
                                    "closer to the bone at rest (down to {}): these nodes may count as inside; take "
                                    "finer cells{}",
                                    mm(cells.cell_m), mm(cells.error_m), percent(share), mm(nearness.rest_gap_m),
                                    cells.parameter.empty() ? "" : fmt::format(" (--param {}=...)", cells.parameter)),
                .figures = {{"cell_m", cells.cell_m},
                            {"error_m", cells.error_m},
                            {"nodes_share", share},
                            {"rest_gap_m", nearness.rest_gap_m}}});
    if (!cells.misses || has_effect(context.scene, "margin")) continue;
    finding.what += ", or a margin, which keeps nodes out of the layer that the cells miss";
    finding.add = {"[effects.margin]", fmt::format("thickness_m = {:.2g}", cells.error_m)};
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

void find_contact_out_of_reach(CheckContext& context, Findings& findings) {
  constexpr std::array of_contact{"margin", "multi_bone", "friction", "surface_contact", "tunnelling_guard"};
  const Scene& scene = context.scene;
  if (has_effect(scene, "gravity")) return;  // a muscle may fall anywhere
  if (std::ranges::none_of(of_contact, [&](const char* effect) { return has_effect(scene, effect); })) return;
  const bool near =
      std::ranges::any_of(context.nearness(), [](const BoneNearness& bone) { return !bone.near.empty(); });
  if (near) return;
  for (const char* effect : of_contact) {
    if (!has_effect(scene, effect)) continue;
    findings.push_back({.kind = FindingKind::cannot_act,
                        .where = fmt::format("effects.{}", effect),
                        .what = "no bone comes nearer to a muscle than the muscle is thick, at any pose (estimated)",
                        .remove = {fmt::format("[effects.{}]", effect)}});
  }
}

/// That three quarters of the nodes exceed, m; nothing where no thickness can be told.
std::optional<double> usual_thickness_m(CheckContext& context) {
  std::vector<double> known;
  std::ranges::copy_if(context.thickness_m(), std::back_inserter(known),
                       [](double thickness) { return thickness > 0; });
  if (known.empty()) return std::nullopt;
  return percentile(std::move(known), 0.25);
}

void find_thick_margin(CheckContext& context, Findings& findings) {
  const auto margin = std::ranges::find(context.scene.effects, "margin", &SceneEffect::name);
  if (margin == context.scene.effects.end()) return;
  const double margin_m = margin->parameters.number("thickness_m");
  const std::optional<double> thickness_m = usual_thickness_m(context);
  if (!thickness_m || margin_m <= *thickness_m) return;
  Finding& finding = findings.emplace_back(
      Finding{.kind = FindingKind::contradiction,
              .where = "effects.margin.thickness_m",
              .what = fmt::format("a skin of {} on the bones is thicker than a quarter of the muscle ({}): between two "
                                  "bones two skins leave it no room; take a millimetre or less",
                                  mm(margin_m), mm(*thickness_m))});
  finding.figures = {{"margin_m", margin_m}, {"muscle_thickness_m", *thickness_m}};
}

void find_thick_self_contact(CheckContext& context, Findings& findings) {
  const auto contact = std::ranges::find(context.scene.effects, "self_contact", &SceneEffect::name);
  if (contact == context.scene.effects.end()) return;
  const double kept_m = contact->parameters.number("thickness_m");
  const std::optional<double> thickness_m = usual_thickness_m(context);
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

const std::vector<SceneRule>& geometry_rules() {
  static const std::vector<SceneRule> rules = {
      {"thick_margin", find_thick_margin},
      {"thick_self_contact", find_thick_self_contact},
      {"out_of_reach", find_contact_out_of_reach},
      {"volume", find_lacking_volume},
      {"tunnelling_guard", find_thin_bones},
      {"surface_contact", find_ridges},
      {"multi_bone", find_pinches},
      {"passed_at_start", find_passed_at_start},
      {"muscle_contact", find_touching_muscles},
      {"self_contact", find_compressed_surfaces},
      {"grid_cells", find_coarse_cells},
      {"feature_thinner_than_cell", find_features_thinner_than_cells},
  };
  return rules;
}

}  // namespace musclebench
