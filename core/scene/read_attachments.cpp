#include "core/scene/read_attachments.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/input_error.hpp"
#include "core/scene/landmarks.hpp"
#include "core/scene/read_contact.hpp"

namespace musclebench {

namespace {

AttachmentSurface read_surface(const TomlTable& table) {
  const std::string near = table.word_or("near", "bone");
  if (near == "bone") return AttachmentSurface::bone;
  if (near == "outline") return AttachmentSurface::outline;
  if (near == "points") return AttachmentSurface::points;
  throw InputError(table.location("near"), fmt::format("'{}' has to be bone, outline or points; did you mean '{}'?",
                                                       near, nearest_word(near, {"bone", "outline", "points"})));
}

/// `bone`: the placement of the bone that carries the area, and so of the outline in its file.
AttachmentArea read_area(const SceneRequest& request, const TomlTable& table, const MeshPlacement& bone) {
  AttachmentArea area;
  if (table.has("outline") == table.has("outline_m")) {
    throw InputError(table.location(), "needs either outline (file#selector) or outline_m (points)");
  }
  if (table.has("outline")) {
    const SceneReference reference = resolve_reference(request, table.word("outline"), table.location("outline"));
    area.outline_m = read_landmark_outline(reference.path, reference.selector, bone);
    area.is_placed = bone.changes_metres();
  } else {
    area.outline_m = table.points("outline_m");
  }
  area.distance_m = table.number("distance_m", 0, 10);
  area.margin_m = table.has("margin_m") ? table.number("margin_m", 0, 10) : 0;
  area.surface = read_surface(table);
  if (area.surface == AttachmentSurface::points) {
    if (area.outline_m.empty()) throw InputError(table.location(), "has no point to be near to");
    if (table.has("margin_m")) throw InputError(table.location("margin_m"), "points have no area; give distance_m");
  } else if (area.outline_m.size() < 3) {
    throw InputError(table.location(), "outlines no area; give at least three points");
  }
  return area;
}

bool is_origin(const TomlTable& table) {
  const std::string end = table.word_or("end", "insertion");
  if (end == "origin" || end == "insertion") return end == "origin";
  throw InputError(table.location("end"), fmt::format("'{}' has to be origin or insertion; did you mean '{}'?", end,
                                                      nearest_word(end, {"origin", "insertion"})));
}

/// Fibres begin at bones and not at areas of them.
void require_one_end(const TomlTable& table, const Attachment& attachment, const Scene& scene) {
  if (!table.has("end")) return;
  for (const Attachment& other : scene.attachments) {
    if (other.muscle != attachment.muscle || other.bone != attachment.bone || other.is_origin == attachment.is_origin) {
      continue;
    }
    throw InputError(
        table.location("end"),
        fmt::format("contradicts attachment '{}' on the same bone: a bone is one end of a muscle", other.name));
  }
}

/// The muscle that the attachment names; in a scene of one muscle it may leave it out.
std::size_t muscle_index(const Scene& scene, const TomlTable& table) {
  if (table.has("muscle")) {
    return find_muscle(scene, table.word("muscle"), table.location("muscle"));
  }
  if (scene.muscles.size() > 1) {
    std::vector<std::string> known;
    for (const Muscle& muscle : scene.muscles) {
      known.push_back(muscle.body.name);
    }
    throw InputError(table.location("muscle"), fmt::format("is missing: in a scene of several muscles an attachment "
                                                           "names its own, {}",
                                                           fmt::join(known, " or ")));
  }
  return 0;
}

}  // namespace

void read_attachments(const SceneRequest& request, const TomlTable& root, Scene& scene) {
  if (root.is_word("attachment")) {
    if (root.word("attachment") != "first_contact") {
      throw InputError(root.location("attachment"), "has to be \"first_contact\", or write [[attachment]] tables");
    }
    scene.attach_at_first_contact = true;
    return;
  }
  const std::vector<TomlTable> tables = root.tables("attachment");
  for (const TomlTable& table : tables) {
    table.allow_only({"name", "bone", "muscle", "end", "near", "outline", "outline_m", "distance_m", "margin_m"});
    Attachment attachment;
    attachment.name = table.word("name");
    attachment.location = table.place();
    attachment.bone = static_cast<int>(find_bone(scene, table.word("bone"), table.location("bone")));
    attachment.muscle = muscle_index(scene, table);
    const auto bone_index = static_cast<std::size_t>(attachment.bone);
    attachment.area = read_area(request, table, scene.bone_meshes[bone_index].placement);
    const Bone& bone = scene.bones[bone_index];
    const Body& body = scene.muscles[attachment.muscle].body;
    attachment.nodes = nodes_over_area(scene.vertices_of(body), bone.surface.mesh, attachment.area);
    for (int& node : attachment.nodes) {
      node += body.first_node;
    }
    attachment.is_origin = is_origin(table);
    require_one_end(table, attachment, scene);
    scene.attachments.push_back(std::move(attachment));
  }
  for (std::size_t i = 0; i < tables.size(); ++i) {
    if (!tables[i].has("end")) continue;
    const bool has_origin = std::ranges::any_of(scene.attachments, [&](const Attachment& other) {
      return other.muscle == scene.attachments[i].muscle && other.is_origin;
    });
    if (!has_origin) {
      throw InputError(tables[i].location("end"), "no attachment of this muscle has end = \"origin\"; name one");
    }
  }
}

}  // namespace musclebench
