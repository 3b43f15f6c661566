#include <map>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/effects/no_passage/passage_overlaps.hpp"
#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

/// What goes through each other as the run begins; which bones lie where then, the motion says.
void find_passed_at_start(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  const SceneEffect* effect = find_named(scene, "no_passage");
  if (effect == nullptr) return;
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

EffectReach reach_of_no_passage(const Scene& scene, const SceneEffect& effect) {
  const bool has_bones = !scene.bones.empty();
  return {effect.name, has_bones, has_bones, scene.muscles.size() > 1, effect.parameters.flag("itself")};
}

}  // namespace

EffectChecks no_passage_checks() {
  return {.rules = {{.id = "passed_at_start", .look = find_passed_at_start, .needs_geometry = true}},
          .reach = reach_of_no_passage};
}

}  // namespace musclebench
