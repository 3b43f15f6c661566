#include <algorithm>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/cases/collider_backends.hpp"
#include "bench/cases/scene_source.hpp"
#include "bench/commands/commands.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/mesh_repair/check_mesh.hpp"
#include "core/referee/referee.hpp"
#include "core/scene/scene_advice.hpp"
#include "core/scene/scene_warnings.hpp"
#include "datasets/embedded/embedded_files.hpp"

namespace musclebench {

namespace {

void print_report(const std::string& title, const TriangleMesh& mesh) {
  fmt::print("{}\n", title);
  for (const std::string& line : describe(check_mesh(mesh))) {
    fmt::print("  {}\n", line);
  }
}

/// Overlap of the muscle's nodes with each bone before anything moves.
void print_overlaps(const Scene& scene) {
  const auto vertices = static_cast<int>(scene.muscle_mesh.vertices.size());
  Referee referee(scene.bones, vertices);
  std::vector<int> nodes(scene.muscle_mesh.vertices.size());
  for (int i = 0; i < vertices; ++i) {
    nodes[i] = i;
  }
  const std::vector<RigidMotion> rest(scene.bones.size());
  std::vector<Contact> contacts;
  referee.judge(rest, scene.muscle_mesh.vertices, nodes, contacts);
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    int inside = 0;
    double deepest_m = 0;
    for (const Contact& contact : contacts) {
      if (contact.bone == static_cast<int>(bone)) {
        ++inside;
        deepest_m = std::max(deepest_m, contact.depth_m);
      }
    }
    fmt::print("overlap with {} at rest: {} of {} nodes inside, {:.3f} mm deep\n", scene.bones[bone].name, inside,
               vertices, deepest_m * 1e3);
  }
}

void print_muscle(const Scene& scene, const Muscle& muscle) {
  print_report(fmt::format("muscle {} ({})", muscle.body.name, muscle.file.reference), muscle.file.mesh);
  for (const std::string& change : muscle.changes) {
    fmt::print("  cleaned for simulation: {}\n", change);
  }
  if (!muscle.changes.empty()) {
    const TriangleMesh simulated = scene.mesh_of(muscle.body);
    print_report(fmt::format("  simulated: {} nodes", simulated.vertices.size()), simulated);
  }
}

/// What keeps the scene from being run: what its reader noted, and a backend that it names and that this build has not
/// or that can't do what it is named for.
std::vector<std::string> obstacles_of(const Scene& scene) {
  std::vector<std::string> obstacles = scene.obstacles;
  try {
    (void)choose_collider_backends({}, scene, exact_backend());
  } catch (const InputError& error) {
    obstacles.emplace_back(error.what());
  }
  return obstacles;
}

void check_scene(const SceneChoice& choice) {
  const Scene scene = load_scene(choice);
  fmt::print("scene {}: {} (preset {})\n", scene.name, scene.title, scene.preset.empty() ? "none" : scene.preset);
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    print_report(fmt::format("bone {} ({})", scene.bones[i].name, scene.bone_meshes[i].reference),
                 scene.bone_meshes[i].mesh);
    for (const std::string& change : scene.bones[i].surface.changes) {
      fmt::print("  repaired for collision: {}\n", change);
    }
  }
  for (const Muscle& muscle : scene.muscles) {
    print_muscle(scene, muscle);
  }
  print_overlaps(scene);
  if (scene.attach_at_first_contact) {
    fmt::print("attachments: nodes that collide before the first frame; their number depends on the backend\n");
  }
  for (const Attachment& attachment : scene.attachments) {
    fmt::print("attachment {}: {} nodes on {}\n", attachment.name, attachment.nodes.size(),
               scene.bones[attachment.bone].name);
  }
  const std::vector<std::string> warnings = scene_warnings(scene);
  const std::vector<std::string> obstacles = obstacles_of(scene);
  for (const std::string& obstacle : obstacles) {
    fmt::print("can't be run: {}\n", obstacle);
  }
  for (const std::string& warning : warnings) {
    fmt::print("warning: {}\n", warning);
  }
  if (warnings.empty() && obstacles.empty()) {
    fmt::print("no warnings\n");
  }
  for (const std::string& line : scene_advice(scene)) {
    fmt::print("the scene calls for: {}\n", line);
  }
}

/// A word that is no file is a scene's, wrongly written: reading scenes says which one may be meant.
bool names_scene(const std::string& target) {
  const auto scenes = embedded_scenes();
  return target.ends_with(".toml") ||
         (!std::filesystem::exists(target) && !std::filesystem::path(target).has_extension()) ||
         std::any_of(scenes.begin(), scenes.end(), [&](const EmbeddedFile& file) { return file.name == target; });
}

}  // namespace

void add_check_command(CLI::App& app, int& exit_code) {
  auto choice = std::make_shared<SceneChoice>();
  CLI::App* command = app.add_subcommand("check", "Print what is wrong with a mesh, or with a scene and its meshes");
  command->add_option("target", choice->scene, "A mesh file (PLY, OBJ, STL, OFF, ...), a scene name or a .toml file")
      ->required();
  command->add_option("--data", choice->data, "Folder of the anatomical data (default: $MUSCLEBENCH_DATA)");
  command->callback([choice, &exit_code] {
    choice->notes_obstacles = true;
    if (names_scene(choice->scene)) {
      check_scene(*choice);
    } else {
      print_report(choice->scene, read_mesh(choice->scene));
    }
    exit_code = 0;
  });
}

}  // namespace musclebench
