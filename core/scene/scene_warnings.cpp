#include "core/scene/scene_warnings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh_repair/check_mesh.hpp"
#include "core/scene/mesh_sizes.hpp"
#include "core/scene/rest_overlap.hpp"

namespace musclebench {

namespace {

using Warnings = std::vector<SceneWarning>;

void warn_of_muscle_files(const Scene& scene, Warnings& warnings) {
  for (const Muscle& muscle : scene.muscles) {
    for (const std::string& change : muscle.changes) {
      if (change.starts_with("merged")) continue;  // an STL has each vertex once a triangle
      warnings.push_back({"cleaned_muscle", fmt::format("muscle '{}': {}", muscle.body.name, change)});
    }
  }
}

/// How many connected pieces a muscle has, and how many of them hold no bound node.
struct Pieces {
  int count = 0;
  int unbound = 0;
};

Pieces pieces_of(const Scene& scene, const Body& body) {
  const TriangleMesh mesh = scene.mesh_of(body);
  const std::vector<int> first = first_of_component(mesh);
  std::vector<char> is_bound(mesh.vertices.size(), 0);
  for (const BoundNode& bound : scene.bound_nodes()) {
    if (body.has_node(bound.node)) {
      is_bound[static_cast<std::size_t>(first[static_cast<std::size_t>(bound.node - body.first_node)])] = 1;
    }
  }
  Pieces pieces;
  for (std::size_t vertex = 0; vertex < first.size(); ++vertex) {
    if (static_cast<std::size_t>(first[vertex]) == vertex) {
      ++pieces.count;
      pieces.unbound += is_bound[vertex] == 0 ? 1 : 0;
    }
  }
  return pieces;
}

void warn_of_pieces(const Scene& scene, Warnings& warnings) {
  for (const Muscle& muscle : scene.muscles) {
    const Pieces pieces = pieces_of(scene, muscle.body);
    if (pieces.count < 2) {
      continue;
    }
    const std::string unbound =
        scene.attachments.empty() ? std::string() : fmt::format(", {} of them without a bound node", pieces.unbound);
    warnings.push_back({"pieces", fmt::format("muscle '{}' is in {} separate pieces{}: nothing holds them together",
                                              muscle.body.name, pieces.count, unbound)});
  }
}

void warn_of_muscle_surfaces(const Scene& scene, Warnings& warnings) {
  for (const Muscle& muscle : scene.muscles) {
    const std::string which = scene.muscles.size() == 1 ? "" : fmt::format(" '{}'", muscle.body.name);
    const MeshReport report = check_mesh(scene.mesh_of(muscle.body));
    if (report.volume_m3 < 0) {
      warnings.push_back(
          {"inward_muscle", fmt::format("the muscle{} is wound inwards (negative volume): turn its triangles", which)});
    }
  }
}

/// What closed a hole is no bone that anybody has measured. What stays open has its inside told by winding numbers,
/// which cost a walk through all of a tree.
void warn_of_holes(const Scene& scene, Warnings& warnings) {
  for (const Bone& bone : scene.bones) {
    for (const std::string& change : bone.surface.changes) {
      if (!change.starts_with("closed")) continue;
      warnings.push_back({"closed_hole", fmt::format("bone '{}': {} by flat fans of triangles; if a muscle touches it "
                                                     "there, mend the mesh",
                                                     bone.name, change)});
    }
    const auto open = std::ranges::find_if(bone.surface.changes,
                                           [](const std::string& change) { return change.starts_with("left open"); });
    if (open == bone.surface.changes.end()) continue;
    warnings.push_back({"open_bone", fmt::format("bone '{}': {}: inside and outside are less certain near its holes, "
                                                 "and exact contact is slower; close the holes",
                                                 bone.name, *open)});
  }
}

std::string what_becomes_of_overlap(const LoopParameters& loop) {
  if (loop.settle_substeps > 0) return "settle_substeps move them out before the first frame";
  if (loop.depenetration_m_per_s == 0) {
    return "the first contact throws them out; [loop] settle_substeps = 30 moves them out gently";
  }
  return fmt::format(
      "contacts push them out at {:.3g} mm/s in the first frames; [loop] settle_substeps = 30 does "
      "so before the first frame",
      1e3 * loop.depenetration_m_per_s);
}

/// Nodes that collide before the first frame are bound where the scene asks for that.
void warn_of_overlaps(const Scene& scene, Warnings& warnings) {
  if (scene.attach_at_first_contact) {
    return;
  }
  const std::vector<RestOverlap> overlaps = free_overlaps_at_rest(scene);
  for (std::size_t bone = 0; bone < overlaps.size(); ++bone) {
    if (overlaps[bone].nodes > 0) {
      warnings.push_back({"overlap_with_bone",
                          fmt::format("{} of {} nodes begin inside bone '{}' without being bound, {:.3g} mm deep: {}",
                                      overlaps[bone].nodes, scene.muscle_mesh.vertices.size(), scene.bones[bone].name,
                                      1e3 * overlaps[bone].deepest_m, what_becomes_of_overlap(scene.loop))});
    }
  }
}

/// Of a pair of the scene's muscles.
std::string pair_names(const Scene& scene, const MusclePair& pair) {
  return fmt::format("'{}' and '{}'", scene.muscles[static_cast<std::size_t>(pair.first)].body.name,
                     scene.muscles[static_cast<std::size_t>(pair.second)].body.name);
}

void warn_of_muscle_pairs(const Scene& scene, Warnings& warnings) {
  if (scene.muscles.size() > 1 && scene.muscle_pairs.empty() && !has_effect(scene, "no_passage")) {
    warnings.push_back(
        {"muscle_pairs", fmt::format("{} muscles without contact between them: they pass through each other; let them "
                                     "collide with [contact] muscle_contact = true, or name two in a [[pair]]",
                                     scene.muscles.size())});
  }
  const std::vector<RestOverlap> overlaps = muscle_overlaps_at_rest(scene);
  for (std::size_t i = 0; i < overlaps.size(); ++i) {
    if (overlaps[i].nodes > 0) {
      warnings.push_back({"muscle_pairs",
                          fmt::format("muscles {} overlap at rest: {} nodes, {:.3g} mm deep; the first steps push them "
                                      "apart",
                                      pair_names(scene, scene.muscle_pairs[i].muscles), overlaps[i].nodes,
                                      1e3 * overlaps[i].deepest_m)});
    }
  }
}

/// A length in another unit than metres: an outline far from the scene, or a distance larger than the muscle.
std::string describe_attachment_unit(const Scene& scene, const Attachment& attachment) {
  constexpr double far = 5;  // sizes of the scene
  const Eigen::AlignedBox3d muscle =
      bounding_box(scene.vertices_of(scene.muscles[static_cast<std::size_t>(attachment.muscle)].body));
  Eigen::AlignedBox3d all = muscle;
  for (const Bone& bone : scene.bones) all.extend(bounding_box(bone.surface.mesh.vertices));
  double farthest_m = 0;
  for (const Vec3& point : attachment.area.outline_m) farthest_m = std::max(farthest_m, all.exteriorDistance(point));
  const std::string cure = "keys that end in _m are metres, whatever the unit of the meshes";
  if (farthest_m > far * all.diagonal().norm()) {
    return fmt::format("attachment '{}': its outline is {:.3g} m away from the scene, which is {:.3g} m large: {}",
                       attachment.name, farthest_m, all.diagonal().norm(), cure);
  }
  const double largest_m = std::max(attachment.area.distance_m, attachment.area.margin_m);
  if (largest_m > muscle.diagonal().norm()) {
    return fmt::format("attachment '{}': distance_m or margin_m is {:.3g} m, and the muscle is {:.3g} m large: {}",
                       attachment.name, largest_m, muscle.diagonal().norm(), cure);
  }
  return {};
}

void warn_of_attachments(const Scene& scene, Warnings& warnings) {
  for (const Attachment& attachment : scene.attachments) {
    const std::string place = attachment.location.empty() ? "" : attachment.location + ": ";
    if (const std::string unit = describe_attachment_unit(scene, attachment); !unit.empty()) {
      warnings.push_back({"unit", place + unit});
    } else if (attachment.nodes.empty()) {
      warnings.push_back({"empty_attachment", place + describe_empty_attachment(scene, attachment)});
    }
  }
}

/// Of a file that is in another unit or frame than its muscle's mesh.
void warn_of_fibres(const Scene& scene, Warnings& warnings) {
  constexpr double margin = 0.1;  // of the muscle's size: fibres may end beyond its surface
  for (const Muscle& muscle : scene.muscles) {
    Eigen::AlignedBox3d box;
    for (const Vec3& vertex : scene.vertices_of(muscle.body)) box.extend(vertex);
    const Vec3 around = Vec3::Constant(margin * box.diagonal().norm());
    const Eigen::AlignedBox3d near(box.min() - around, box.max() + around);
    std::size_t outside = 0;
    for (const FibreSegment& fibre : muscle.fibres) {
      outside += (near.contains(fibre.start) ? 0U : 1U) + (near.contains(fibre.end) ? 0U : 1U);
    }
    if (outside <= muscle.fibres.size()) continue;
    warnings.push_back(
        {"fibres_outside",
         fmt::format("muscle '{}': {} of {} points of its fibres are outside it; their file has to be in "
                     "metres in the frame of the mesh file: scale, rotate_deg and translate_m in the "
                     "muscle's table ({}) move them, unit does not",
                     muscle.body.name, outside, 2 * muscle.fibres.size(), muscle.file.location)});
  }
}

void warn_of_late_time_steps(const Scene& scene, Warnings& warnings) {
  for (const TimeStepChange& change : scene.loop.time_step_changes) {
    if (change.from_frame <= scene.loop.frames) continue;
    warnings.push_back(
        {"late_time_step",
         fmt::format("the time step changes from frame {} on, but the run has {} frames: it never changes",
                     change.from_frame, scene.loop.frames)});
  }
}

void warn_of_motions(const Scene& scene, Warnings& warnings) {
  if (std::abs(scene.angle_rad(0)) > 1e-9) {
    warnings.push_back(
        {"motion",
         fmt::format("the motion starts at {:.3g} degrees from the pose of the meshes: the bones jump there in "
                     "the first frame",
                     scene.angle_rad(0) * degrees_per_radian)});
  }
  for (std::size_t bone = 0; bone < scene.motions.size(); ++bone) {
    for (const BoneRotation& rotation : scene.motions[bone].rotations) {
      const auto [least, largest] = std::ranges::minmax(rotation.angles_rad);
      if (largest - least > 2 * std::numbers::pi * (1 + 1e-9)) {
        warnings.push_back({"motion", fmt::format("bone '{}' turns by {:.4g} degrees, more than a full turn: check its "
                                                  "angles (in a table, the line inDegrees "
                                                  "gives their unit)",
                                                  scene.bones[bone].name, (largest - least) * degrees_per_radian)});
      }
    }
  }
}

}  // namespace

std::string describe_empty_attachment(const Scene& scene, const Attachment& attachment) {
  const Bone& bone = scene.bones[static_cast<std::size_t>(attachment.bone)];
  const auto nearest =
      nearest_to_area(scene.vertices_of(scene.muscles[attachment.muscle].body), bone.tree(), attachment.area);
  const std::string placed =
      attachment.area.is_placed
          ? fmt::format(" (scale, rotate_deg and translate_m of bone '{}' move it; outline_m gives points that stay)",
                        bone.name)
          : std::string();
  if (!nearest) {
    return fmt::format(
        "attachment '{}' binds no node: the muscle is nowhere on its side of bone '{}'; check its outline{}",
        attachment.name, bone.name, placed);
  }
  if (attachment.area.surface == AttachmentSurface::points) {
    return fmt::format(
        "attachment '{}' binds no node: the nearest is {:.4g} mm from its points (distance_m allows {:.4g} mm); were "
        "they taken from this mesh?{}",
        attachment.name, 1e3 * nearest->to_surface_m, 1e3 * attachment.area.distance_m, placed);
  }
  const bool is_near_bone = attachment.area.surface == AttachmentSurface::bone;
  return fmt::format(
      "attachment '{}' binds no node: the nearest is {:.4g} mm from {} (distance_m allows {:.4g} mm) and {:.4g} mm "
      "outside the outlined area (margin_m allows {:.4g} mm); enlarge them or check its outline{}",
      attachment.name, 1e3 * nearest->to_surface_m,
      is_near_bone ? fmt::format("bone '{}'", bone.name) : std::string("the outline's plane"),
      1e3 * attachment.area.distance_m, 1e3 * nearest->beside_area_m, 1e3 * attachment.area.margin_m, placed);
}

std::string describe_missing_fibres(const Scene& scene, std::size_t muscle) {
  const Body& body = scene.muscles[muscle].body;
  constexpr const char* needs = "'between_attachments' needs bound nodes on two bones that the muscle joins";
  if (std::ranges::find(scene.attachments, muscle, &Attachment::muscle) == scene.attachments.end()) {
    return fmt::format("{}, and the scene has no [[attachment]]{}", needs,
                       scene.muscles.size() == 1 ? "" : fmt::format(" of muscle '{}'", body.name));
  }
  std::vector<std::string> counts;
  for (const SceneWarning& size : size_warnings(scene)) counts.push_back(size.text);  // a wrong unit explains the rest
  std::vector<int> bones;
  for (const Attachment& attachment : scene.attachments) {
    if (attachment.muscle != muscle) continue;
    const Bone& bone = scene.bones[static_cast<std::size_t>(attachment.bone)];
    if (attachment.nodes.empty()) {
      counts.push_back(describe_empty_attachment(scene, attachment));
    } else {
      counts.push_back(fmt::format("attachment '{}' has {} nodes on bone '{}'", attachment.name,
                                   attachment.nodes.size(), bone.name));
    }
  }
  for (const BoundNode& bound : scene.bound_nodes()) {
    if (body.has_node(bound.node)) bones.push_back(bound.bone);
  }
  std::sort(bones.begin(), bones.end());
  bones.erase(std::unique(bones.begin(), bones.end()), bones.end());
  const Pieces pieces = pieces_of(scene, body);
  if (bones.size() > 1 && pieces.count > 1) {
    counts.push_back(fmt::format("the muscle is in {} separate pieces, none of which joins them", pieces.count));
  } else if (bones.size() == 1) {
    counts.push_back(
        fmt::format("all bound nodes are on bone '{}'", scene.bones[static_cast<std::size_t>(bones[0])].name));
  }
  return fmt::format("{}: {}", needs, fmt::join(counts, "; "));
}

std::vector<SceneWarning> scene_warnings(const Scene& scene) {
  Warnings warnings = size_warnings(scene);
  warn_of_muscle_files(scene, warnings);
  warn_of_pieces(scene, warnings);
  warn_of_holes(scene, warnings);
  warn_of_attachments(scene, warnings);
  warn_of_overlaps(scene, warnings);
  warn_of_muscle_pairs(scene, warnings);
  warn_of_muscle_surfaces(scene, warnings);
  warn_of_fibres(scene, warnings);
  warn_of_motions(scene, warnings);
  warn_of_late_time_steps(scene, warnings);
  return warnings;
}

}  // namespace musclebench
