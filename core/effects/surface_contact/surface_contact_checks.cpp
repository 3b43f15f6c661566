#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/mesh/mesh_size.hpp"
#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/ridge_depth.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

void find_late_surface_contact(CheckContext& context, Findings& findings) {
  const SceneEffect* contact = find_named(context.scene, "surface_contact");
  if (contact == nullptr) return;
  const auto interval = static_cast<double>(contact->parameters.integer("interval"));
  const LoopParameters& loop = context.scene.loop;
  const double steps = static_cast<double>(loop.frames) * loop.substeps * loop.iterations;
  if (interval < steps) return;
  Finding& finding = findings.emplace_back(
      cannot_act(key_of("surface_contact", "interval"),
                 fmt::format("searches only every {:.0f} collision steps, and the run has {:.0f}", interval, steps)));
  finding.figures = {{"interval", interval}, {"steps", steps}};
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

}  // namespace

EffectChecks surface_contact_checks() {
  return {.rules = {{.id = "late_surface_contact", .look = find_late_surface_contact},
                    {.id = "bound_faces", .look = find_bound_faces_in_contact},
                    {.id = "surface_contact", .look = find_ridges, .needs_geometry = true}},
          .reach = [](const Scene& scene, const SceneEffect& effect) {
            return EffectReach{.effect = effect.name, .surface = !scene.bones.empty()};
          }};
}

}  // namespace musclebench
