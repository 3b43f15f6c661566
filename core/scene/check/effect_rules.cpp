#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/effects/effect_registry.hpp"
#include "core/effects/fibre_force.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/scene/check/scene_check.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

const SceneEffect* find_named(const Scene& scene, std::string_view name) {
  const auto found = std::ranges::find(scene.effects, name, &SceneEffect::name);
  return found == scene.effects.end() ? nullptr : &*found;
}

/// By the scene itself and not by its preset.
bool is_given_by_scene(const SceneEffect& effect, std::string_view parameter) {
  return std::ranges::find(effect.own_keys, parameter) != effect.own_keys.end();
}

bool has_fibres(const Muscle& muscle) { return muscle.fibres_between_attachments || !muscle.fibres.empty(); }

std::string key_of(std::string_view effect, std::string_view parameter = {}) {
  return parameter.empty() ? fmt::format("effects.{}", effect) : fmt::format("effects.{}.{}", effect, parameter);
}

Finding cannot_act(std::string where, std::string what) {
  return {.kind = FindingKind::cannot_act, .where = std::move(where), .what = std::move(what)};
}

/// An effect that has this value of a parameter does nothing.
struct NeutralValue {
  std::string_view effect;
  std::string_view parameter;
};

constexpr std::array neutral_at_zero{
    NeutralValue{"damping", "rate_per_s"},
    NeutralValue{"edge_length", "stiffness"},
    NeutralValue{"activation", "level"},
    NeutralValue{"activation", "shortening"},
    NeutralValue{"fibre_force", "peak_stress_pa"},
    NeutralValue{"volume", "projection_scale"},
    NeutralValue{"local_volume", "projection_scale"},
    NeutralValue{"bending", "stiffness"},
    NeutralValue{"margin", "thickness_m"},
    NeutralValue{"friction", "coefficient"},
};

void find_zeros(CheckContext& context, Findings& findings) {
  for (const auto& [effect, parameter] : neutral_at_zero) {
    const SceneEffect* named = find_named(context.scene, effect);
    if (named == nullptr || named->parameters.number(std::string(parameter)) != 0) continue;
    Finding& finding = findings.emplace_back(
        cannot_act(key_of(effect, parameter), "is 0: the effect costs its time and changes nothing"));
    finding.figures = {{std::string(parameter), 0}};
    finding.remove = {fmt::format("[effects.{}]", effect)};
  }
  const SceneEffect* gravity = find_named(context.scene, "gravity");
  if (gravity == nullptr) return;
  for (const char* axis : {"x_m_per_s2", "y_m_per_s2", "z_m_per_s2"}) {
    if (gravity->parameters.number(axis) != 0) return;
  }
  findings.push_back(cannot_act(key_of("gravity"), "is 0 along all axes: it moves nothing"));
  findings.back().remove = {"[effects.gravity]"};
}

void find_effects_without_fibres(CheckContext& context, Findings& findings) {
  const SceneEffect* lengths = find_named(context.scene, "edge_length");
  const double exponent = lengths == nullptr ? 0 : lengths->parameters.number("anisotropy_exponent");
  for (const Muscle& muscle : context.scene.muscles) {
    if (has_fibres(muscle)) continue;
    const std::string what = fmt::format("needs fibres, and muscle '{}' has none", muscle.body.name);
    if (find_named(context.scene, "activation") != nullptr) {
      findings.push_back(cannot_act(key_of("activation"), what));
      findings.back().add = {"fibres = \"between_attachments\""};
    }
    // Presets give every scene the exponent; one that asks for it itself would see it.
    if (exponent != 0 && is_given_by_scene(*lengths, "anisotropy_exponent")) {
      findings.push_back(cannot_act(key_of("edge_length", "anisotropy_exponent"), what));
      findings.back().figures = {{"anisotropy_exponent", exponent}};
      findings.back().add = {"fibres = \"between_attachments\""};
    }
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

long collision_steps(const LoopParameters& loop) {
  return static_cast<long>(loop.frames) * loop.substeps * loop.iterations;
}

void find_late_surface_contact(CheckContext& context, Findings& findings) {
  const SceneEffect* contact = find_named(context.scene, "surface_contact");
  if (contact == nullptr) return;
  const auto interval = static_cast<double>(contact->parameters.integer("interval"));
  const auto steps = static_cast<double>(collision_steps(context.scene.loop));
  if (interval < steps) return;
  Finding& finding = findings.emplace_back(
      cannot_act(key_of("surface_contact", "interval"),
                 fmt::format("searches only every {:.0f} collision steps, and the run has {:.0f}", interval, steps)));
  finding.figures = {{"interval", interval}, {"steps", steps}};
}

/// What effects leave out: they look at nodes in bones, while others hold faces, edges or muscles.
struct PartialEffect {
  std::string_view effect;
  std::string_view other;
  std::string_view what;
};

constexpr std::array partial_effects{
    PartialEffect{"margin", "self_contact", "acts on bones only: self_contact has its own thickness"},
};

void find_partial_effects(CheckContext& context, Findings& findings) {
  for (const auto& [effect, other, what] : partial_effects) {
    if (!has_effect(context.scene, effect) || !has_effect(context.scene, other)) continue;
    findings.push_back({.kind = FindingKind::acts_in_part, .where = key_of(effect), .what = std::string(what)});
  }
  if (has_effect(context.scene, "margin") && !context.scene.muscle_pairs.empty()) {
    findings.push_back({.kind = FindingKind::acts_in_part,
                        .where = key_of("margin"),
                        .what = "acts on bones only: it keeps no distance between muscles"});
  }
}

/// The carrier of each node; -1: free.
std::vector<int> carriers_of(const Scene& scene) {
  std::vector<int> carriers(scene.muscle_mesh.vertices.size(), -1);
  for (const BoundNode& bound : scene.bound_nodes()) carriers[static_cast<std::size_t>(bound.node)] = bound.bone;
  return carriers;
}

/// Of a bone, the faces that have free corners and such as are bound to another bone, and that lie nearer to it than
/// their longest edge.
int bound_faces_near(const Scene& scene, int bone, std::span<const int> carriers) {
  const TriangleMesh& mesh = scene.muscle_mesh;
  const Bone& of_bone = scene.bones[static_cast<std::size_t>(bone)];
  const Eigen::AlignedBox3d box = bounding_box(of_bone.surface.mesh.vertices);
  int faces = 0;
  for (const Triangle& triangle : mesh.triangles) {
    const auto carrier = [&](int corner) { return carriers[static_cast<std::size_t>(corner)]; };
    const auto position = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(triangle[k])]; };
    if (std::ranges::any_of(triangle, [&](int corner) { return carrier(corner) == bone; })) continue;
    const auto free = std::ranges::count_if(triangle, [&](int corner) { return carrier(corner) < 0; });
    if (free == 0 || free == 3) continue;
    const Vec3 centre = (position(0) + position(1) + position(2)) / 3;
    const double edge_m = std::max(
        {(position(0) - position(1)).norm(), (position(1) - position(2)).norm(), (position(2) - position(0)).norm()});
    if (box.exteriorDistance(centre) > edge_m) continue;
    const auto closest = of_bone.tree().closest_point(centre);
    if (closest && closest->distance_m < edge_m) ++faces;
  }
  return faces;
}

/// A correction of such a face moves its free corners alone, by its gap over their share of the weight.
void find_bound_faces_in_contact(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  if (!has_effect(scene, "surface_contact") || scene.attachments.empty()) return;
  const std::vector<int> carriers = carriers_of(scene);
  for (int bone = 0; bone < static_cast<int>(scene.bones.size()); ++bone) {
    const int faces = bound_faces_near(scene, bone, carriers);
    if (faces == 0) continue;
    findings.push_back(
        {.kind = FindingKind::contradiction,
         .where = fmt::format("effects.surface_contact, bone '{}'", scene.bones[static_cast<std::size_t>(bone)].name),
         .what = fmt::format("{} faces near it have corners that are bound to another bone: pushing "
                             "such a face out throws its free corners; outline smaller attachments, or "
                             "leave the effect out",
                             faces),
         .figures = {{"faces", static_cast<double>(faces)}}});
  }
}

void find_late_activation(CheckContext& context, Findings& findings) {
  const LoopParameters& loop = context.scene.loop;
  const double end_s = loop.time_s(loop.frames, loop.substeps);
  for (const char* effect : {"activation", "fibre_force"}) {
    const SceneEffect* activation = find_named(context.scene, effect);
    if (activation == nullptr) continue;
    const double start_s = activation->parameters.number("start_s");
    if (start_s < end_s) continue;
    Finding& finding = findings.emplace_back(cannot_act(
        key_of(effect, "start_s"), fmt::format("begins at {:.4g} s, and the run ends at {:.4g} s", start_s, end_s)));
    finding.figures = {{"start_s", start_s}, {"end_s", end_s}};
  }
}

void find_fibres_without_ends(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  if (find_named(scene, "fibre_force") == nullptr || scene.attach_at_first_contact) return;
  for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
    std::set<int> bones;
    for (const Attachment& attachment : scene.attachments) {
      if (attachment.muscle == muscle && !attachment.nodes.empty()) bones.insert(attachment.bone);
    }
    if (bones.size() > 1) continue;
    findings.push_back(cannot_act(
        key_of("fibre_force"),
        fmt::format("pulls on no fibres of muscle '{}', which is attached to {}: they run from the bone of its first "
                    "[[attachment]], or from those with end = \"origin\", to its other bones",
                    scene.muscles[muscle].body.name, bones.empty() ? "no bone" : "one bone only")));
  }
}

void find_speed_of_jumps(CheckContext& context, Findings& findings) {
  const SceneEffect* fibres = find_named(context.scene, "fibre_force");
  if (fibres == nullptr || context.scene.loop.interpolate_poses) return;
  if (std::ranges::none_of(context.scene.motions, &BoneMotion::turns)) return;
  if (fibres->parameters.number("level") == 0 || fibres->parameters.number("fastest_per_s") == 0) return;
  findings.push_back(
      {.kind = FindingKind::contradiction,
       .where = "loop.bone_motion",
       .what =
           "bones jump to the pose of a frame in its first substep, and the force of active fibres depends on their "
           "speed: write bone_motion = \"interpolated\" below [loop], or fastest_per_s = 0 below "
           "[effects.fibre_force]"});
}

/// Of a scene as it would run.
double longest_fibre_step_s(const Scene& scene, const Parameters& parameters) {
  const std::vector<BoundNode> bound = scene.bound_nodes();
  const std::vector<Body> bodies = scene.bodies();
  const NodeOrder order(scene.muscle_mesh.vertices, bodies);
  std::vector<EndNodes> ends;
  std::vector<double> inverse_masses;
  for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
    ends.push_back(scene.end_nodes(muscle, bound));
    inverse_masses.resize(static_cast<std::size_t>(bodies[muscle].last_node),
                          1 / node_mass_kg(scene, scene.muscles[muscle]));
  }
  for (const BoundNode& node : bound) inverse_masses[static_cast<std::size_t>(node.node)] = 0;
  const std::vector<std::vector<FibreSegment>> fibres(bodies.size());
  const std::vector<RigidMotion> poses(scene.bones.size());
  return longest_fibre_step_s({scene.muscle_mesh, bodies, order, fibres, bound, poses, ends}, parameters,
                              inverse_masses);
}

void find_steps_too_long_for_fibres(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  const SceneEffect* fibres = find_named(scene, "fibre_force");
  if (fibres == nullptr || scene.attach_at_first_contact || fibres->parameters.number("level") == 0) return;
  const double longest_s = longest_fibre_step_s(scene, fibres->parameters);
  double step_s = scene.loop.time_step_s;
  for (const TimeStepChange& change : scene.loop.time_step_changes) step_s = std::max(step_s, change.time_step_s);
  if (!(step_s > longest_s)) return;
  const double times = std::ceil(step_s / longest_s);
  Finding& finding = findings.emplace_back(Finding{
      .kind = FindingKind::contradiction,
      .where = key_of("fibre_force", "level"),
      .what = fmt::format("pulls so hard that the muscle may crumple with steps of {:.3g} ms: take {:.0f} times as "
                          "many substeps of {:.3g} ms, or a lower level",
                          1e3 * step_s, times, 1e3 * step_s / times)});
  finding.figures = {{"time_step_s", step_s}, {"longest_time_step_s", longest_s}};
}

void find_attachments(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  const bool wants = scene.attach_at_first_contact || !scene.attachments.empty();
  const bool has = has_effect(scene, "attachment");
  if (has && !wants) {
    findings.push_back(cannot_act(key_of("attachment"), "has nothing to act on: the scene has no [[attachment]]"));
    findings.back().remove = {"[effects.attachment]"};
  }
  if (has || !wants) return;
  findings.push_back({.where = "attachment",
                      .what = "the scene has attachments, but no effect moves their nodes: the nodes stand still while "
                              "the bones move",
                      .add = {"[effects.attachment]"},
                      .effect = AdvisedEffect{"attachment"}});
}

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

void find_lacking_lengths(CheckContext& context, Findings& findings) {
  if (has_effect(context.scene, "edge_length")) return;
  // Activation gives every edge a length, too, by its angle to the fibres.
  if (has_effect(context.scene, "activation") && std::ranges::all_of(context.scene.muscles, has_fibres)) return;
  findings.push_back({.where = "muscle",
                      .what = "no effect holds its surface together",
                      .add = {"[effects.edge_length]"},
                      .effect = AdvisedEffect{"edge_length"}});
}

void find_volumes_of_open_muscles(CheckContext& context, Findings& findings) {
  for (const char* effect : {"volume", "local_volume", "fibre_force"}) {
    if (!has_effect(context.scene, effect)) continue;
    for (std::size_t i = 0; i < context.scene.muscles.size(); ++i) {
      if (is_closed_muscle(context.scene, i)) continue;
      findings.push_back(cannot_act(
          key_of(effect), fmt::format("has no meaning for muscle '{}', whose surface is open: close it (`musclebench "
                                      "check` counts its boundary edges)",
                                      context.scene.muscles[i].body.name)));
      findings.back().remove = {fmt::format("[effects.{}]", effect)};
    }
  }
}

void find_two_volumes(CheckContext& context, Findings& findings) {
  if (!has_effect(context.scene, "volume") || !has_effect(context.scene, "local_volume")) return;
  findings.push_back(
      cannot_act(key_of("volume"), "adds nothing to local_volume, whose regions together are the whole muscle"));
  if (find_named(context.scene, "volume")->is_own) {
    findings.back().remove = {"[effects.volume]"};
  } else {
    findings.back().add = {"volume = false under [effects]"};
  }
}

void find_ignored_guard_angle(CheckContext& context, Findings& findings) {
  const SceneEffect* guard = find_named(context.scene, "tunnelling_guard");
  if (guard == nullptr || guard->parameters.word("rule") == "angle" || !guard->parameters.given("angle_deg")) return;
  Finding& finding = findings.emplace_back(
      cannot_act(key_of("tunnelling_guard", "angle_deg"), "applies to rule 'angle' only, and the rule is 'crossing'"));
  finding.figures = {{"angle_deg", guard->parameters.number("angle_deg")}};
  finding.remove = {"angle_deg"};
}

void find_multi_bone_of_one(CheckContext& context, Findings& findings) {
  if (!has_effect(context.scene, "multi_bone") || context.scene.bones.size() > 1) return;
  findings.push_back(cannot_act(key_of("multi_bone"), "is for nodes in several bones, and the scene has one"));
  findings.back().remove = {"[effects.multi_bone]"};
}

void find_overruled_steps(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  if (!has_effect(scene, "multi_bone") || scene.response_steps_location.empty() || !scene.muscle_pairs.empty()) return;
  Finding& finding = findings.emplace_back(
      cannot_act("contact.steps", "multi_bone ignores it, and takes as many steps as leaving all bones needs"));
  finding.figures = {{"steps", static_cast<double>(scene.response_steps)}};
  finding.remove = {fmt::format("steps = {}", scene.response_steps)};
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
  if (has_effect(scene, "gravity") || has_effect(scene, "activation") || has_effect(scene, "fibre_force")) return;
  for (const char* volume : {"volume", "local_volume"}) {
    const SceneEffect* inflated = find_named(scene, volume);
    if (inflated != nullptr && inflated->parameters.number("pressure") != 1) return;
  }
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

}  // namespace

const std::vector<SceneRule>& effect_rules() {
  static const std::vector<SceneRule> rules = {
      {"zero_parameter", find_zeros},
      {"no_fibres", find_effects_without_fibres},
      {"ignored_fibres", find_ignored_fibres},
      {"late_activation", find_late_activation},
      {"no_fibre_ends", find_fibres_without_ends},
      {"speed_of_jumps", find_speed_of_jumps},
      {"fibre_steps", find_steps_too_long_for_fibres},
      {"late_surface_contact", find_late_surface_contact},
      {"partial_effect", find_partial_effects},
      {"bound_faces", find_bound_faces_in_contact},
      {"attachment", find_attachments},
      {"retinaculum", find_retinacula},
      {"edge_length", find_lacking_lengths},
      {"open_volume", find_volumes_of_open_muscles},
      {"two_volumes", find_two_volumes},
      {"ignored_guard_angle", find_ignored_guard_angle},
      {"one_bone", find_multi_bone_of_one},
      {"overruled_steps", find_overruled_steps},
      {"backtracking", find_backtracking},
      {"all_bound", find_all_bound},
      {"foreign_fibres", find_foreign_fibres},
      {"standstill", find_standstill},
      {"idle_exclusion", find_idle_exclusions},
      {"claimed_attachment", find_claimed_attachments},
  };
  return rules;
}

}  // namespace musclebench
