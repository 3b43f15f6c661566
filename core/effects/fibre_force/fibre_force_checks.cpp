#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "core/effects/fibre_force/fibre_force.hpp"
#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

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

}  // namespace

EffectChecks fibre_force_checks() {
  return {.rules = {late_start_rule("fibre_force"),
                    {.id = "no_fibre_ends", .look = find_fibres_without_ends},
                    {.id = "speed_of_jumps", .look = find_speed_of_jumps},
                    {.id = "fibre_steps", .look = find_steps_too_long_for_fibres},
                    open_volume_rule("fibre_force")},
          .moves = [](const SceneEffect& /*effect*/) { return true; }};
}

}  // namespace musclebench
