#include <algorithm>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/cases/bone_cells.hpp"
#include "bench/cases/collider_backends.hpp"
#include "bench/cases/safe_steps.hpp"
#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/commands/effect_options.hpp"
#include "bench/commands/effect_trials.hpp"
#include "bench/process/progress.hpp"
#include "bench/results/findings_json.hpp"
#include "core/base/input_error.hpp"
#include "core/base/output_file.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/mesh_repair/check_mesh.hpp"
#include "core/scene/check/effect_reach.hpp"
#include "core/scene/check/scene_check.hpp"
#include "core/scene/mesh_sizes.hpp"
#include "core/scene/rest_overlap.hpp"
#include "core/scene/scene_warnings.hpp"
#include "datasets/embedded/embedded_files.hpp"

namespace musclebench {

namespace {

constexpr int check_steps = 1000;

void print_report(const std::string& title, const TriangleMesh& mesh) {
  fmt::print("{}\n", title);
  for (const std::string& line : describe(check_mesh(mesh))) {
    fmt::print("  {}\n", line);
  }
}

/// Of the muscles' nodes with each bone before anything moves: contacts push out those that are free, and bones hold
/// those that are attached.
void print_overlaps(const Scene& scene) {
  const std::vector<RestOverlap> free = free_overlaps_at_rest(scene);
  const std::vector<RestOverlap> attached = attached_overlaps_at_rest(scene);
  const auto told = [](const RestOverlap& overlap, const char* kind) {
    return fmt::format("{} of {} {} nodes inside{}", overlap.nodes, overlap.of_nodes, kind,
                       overlap.nodes > 0 ? fmt::format(", {:.3f} mm deep", overlap.deepest_m * 1e3) : "");
  };
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    fmt::print("overlap with {} at rest: {}; {}\n", scene.bones[bone].name, told(free[bone], "free"),
               told(attached[bone], "attached"));
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

struct CheckRequest {
  SceneChoice scene;
  BackendOptions backend;
  EffectOptions effects;
  std::vector<std::string> wanted;
  std::string safe_steps;
  bool json = false;
  bool trial = false;
  std::string out;  ///< file for the scene with what the trial added
};

/// Among the obstacles: a backend that the scene names and that this build has not or that can't do what it is named
/// for.
void note_backends(Scene& scene) {
  try {
    (void)choose_collider_backends({}, scene, exact_backend());
  } catch (const InputError& error) {
    scene.obstacles.emplace_back(error.what());
  }
}

/// `report` shows what is not done in a moment.
CheckOptions check_options(const CheckRequest& request, Scene& scene, std::vector<SceneWarning>& warnings,
                           Progress& progress) {
  CheckOptions options;
  options.report = [&progress](int done, int total) { progress.show(done * check_steps / total); };
  if (request.backend.backend.empty()) {
    note_backends(scene);
    return options;
  }
  const BackendEntry& backend = find_backend(request.backend.backend);
  const Parameters parameters = backend_parameters(backend, request.backend.parameters);
  const ColliderBackends colliders = choose_collider_backends(request.backend.colliders, scene, backend);
  try {
    const std::vector<ResponseKind> responses =
        choose_responses(request.backend.response, scene, backend, parameters, colliders);
    require_what_effects_need(scene, backend, parameters, responses, colliders);
    for (const std::string& line : effects_without_contacts(scene, backend, parameters, colliders)) {
      warnings.push_back({"no_contacts", line});
    }
  } catch (const InputError& obstacle) {
    scene.obstacles.emplace_back(obstacle.what());
  }
  Case resolved{scene, backend, parameters, request.backend.threads};
  resolved.colliders = colliders;
  options.cells = bone_cells(resolved);
  return options;
}

void print_meshes(const Scene& scene) {
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
}

void print_attachments(const Scene& scene) {
  if (scene.attach_at_first_contact) {
    fmt::print("attachments: nodes that collide before the first frame; their number depends on the backend\n");
  }
  for (const Attachment& attachment : scene.attachments) {
    fmt::print("attachment {}: {} nodes on {}\n", attachment.name, attachment.nodes.size(),
               scene.bones[attachment.bone].name);
  }
}

void print_verdict(const Scene& scene, const std::vector<SceneWarning>& warnings, const Findings& findings,
                   bool is_tried) {
  for (const std::string& obstacle : scene.obstacles) {
    fmt::print("can't be run: {}\n", obstacle);
  }
  for (const SceneWarning& warning : warnings) {
    fmt::print("warning: {}\n", warning.text);
  }
  for (const AddedEffect& added : scene.auto_effects.added) {
    fmt::print("added {} [{}]: {}\n", added.effect, added.rule, added.reason);
  }
  for (const Finding& finding : findings) {
    fmt::print("{}\n", text_of(finding));
  }
  if (waits_for_trials(scene) && !is_tried) {
    fmt::print("a run looks for effects that hold what is wanted; --trial shows which\n");
  }
  if (warnings.empty() && findings.empty() && scene.obstacles.empty()) {
    fmt::print("no warnings\n");
  }
}

/// Runs the scene with the effects that it names and others, and adds those that it takes.
EffectChoice try_scene(const CheckRequest& request, const SceneChoice& choice, Scene& scene) {
  scene.warnings = warnings_of(scene);
  EffectChoice chosen = choose_effects_with_progress(scene, {.looks_for_needless = true, .judges_the_end = true});
  if (!request.out.empty() && !chosen.was_refused) {
    OutputFile file(request.out);
    file.stream() << resolved_scene(choice, scene);
    file.close();
  }
  return chosen;
}

/// Whether the scene can be run.
bool check_scene_of(const CheckRequest& request) {
  if (!request.trial && (!request.out.empty() || !request.wanted.empty())) {
    throw InputError(request.out.empty() ? "--wanted" : "--out", "is of a trial: add --trial");
  }
  SceneChoice choice = request.scene;
  choice.effect_overrides = effect_overrides(request.effects);
  choice.wanted_overrides = wanted_overrides(request.wanted);
  Scene scene = load_scene(choice);
  std::vector<SceneWarning> warnings = scene_warnings(scene);
  Findings findings;
  {
    Progress progress(progress_style(false), "check " + scene.name, check_steps);
    findings = check_scene(scene, check_options(request, scene, warnings, progress));
  }
  if (!request.safe_steps.empty()) {
    const Findings beyond = safe_step_findings(read_safe_steps(request.safe_steps), scene, request.backend.backend);
    findings.insert(findings.end(), beyond.begin(), beyond.end());
  }
  std::error_code no_such_file;
  if (!request.out.empty() && std::filesystem::equivalent(request.out, choice.scene, no_such_file)) {
    throw InputError("--out " + request.out, "is the scene itself; give another file");
  }
  if (!request.out.empty() && std::filesystem::path(request.out).extension() != ".toml") {
    throw InputError("--out " + request.out, "is written as a scene; give a name such as found.toml");
  }
  if (std::filesystem::is_directory(request.out, no_such_file)) {
    throw InputError("--out " + request.out, "is a folder; give a file");
  }
  const std::filesystem::path folder = std::filesystem::path(request.out).parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, no_such_file)) {
    throw InputError("--out " + request.out, "is in a folder that does not exist; make it first");
  }
  const Scene before = scene;
  std::optional<EffectChoice> tried;
  if (request.trial && scene.obstacles.empty()) tried = try_scene(request, choice, scene);
  if (request.json) {
    Json json = json_of_check(before, warnings, findings);
    if (tried) json["trial"] = json_of(*tried);
    fmt::print("{}\n", text_of(json, 2));
    return scene.obstacles.empty() && !(tried && tried->was_refused);
  }
  fmt::print("scene {}: {} (preset {})\n", scene.name, scene.title, scene.preset.empty() ? "none" : scene.preset);
  print_meshes(scene);
  print_overlaps(scene);
  print_attachments(scene);
  for (const EffectReach& reach : effect_reaches(before)) {
    fmt::print("effect {} acts on: {}\n", reach.effect, reach.text());
  }
  print_verdict(before, warnings, findings, request.trial);
  if (request.trial && !tried) fmt::print("no trial: the scene can't be run\n");
  if (tried) {
    for (const std::string& line : lines_of(scene, *tried)) fmt::print("{}\n", line);
    return !tried->was_refused;
  }
  return scene.obstacles.empty();
}

/// Of a mesh there is its report only.
void check_mesh_of(const CheckRequest& request) {
  if (request.json || request.trial || !request.out.empty() || !request.wanted.empty() ||
      !request.backend.backend.empty() || !request.scene.preset.empty() || !request.safe_steps.empty()) {
    throw InputError(
        request.scene.scene,
        "is a mesh; --json, --trial, --wanted, --out, --preset, --backend and --safe-step are for scenes; leave "
        "them out");
  }
  const TriangleMesh mesh = read_mesh(request.scene.scene);
  print_report(request.scene.scene, mesh);
  if (const auto warning = size_warning(mesh)) fmt::print("warning: {}\n", *warning);
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
  auto request = std::make_shared<CheckRequest>();
  CLI::App* command = app.add_subcommand(
      "check", "Check a mesh or a scene: report defects of meshes, missing effects, and effects that cannot act");
  command->footer(
      "Example: musclebench check synthetic/iliacus --backend sdf --param cells=128\n"
      "Each finding has a reason and, where one is known, the lines to add to the scene.\n"
      "Exit codes: 0 the scene can run, 2 it cannot.");
  command->add_option("target", request->scene.scene, "Mesh file (PLY, OBJ, STL, OFF, ...), scene name or .toml file")
      ->required();
  command->add_option("--preset", request->scene.preset, "Loop and effects: paper or standard (default: the scene's)");
  command->add_option("--data", request->scene.data, "Folder of the anatomical data (default: $MUSCLEBENCH_DATA)");
  add_backend_options(*command, request->backend);
  command->get_option("--backend")
      ->required(false)
      ->description(
          "Also check that this backend serves the effects and that its cells are finer than gaps between bones");
  command->add_option("--safe-step", request->safe_steps,
                      "File safe_step.json of tools/safe-step: compare the scene's step with the largest safe step");
  add_effect_options(*command, request->effects);
  command->add_flag(
      "--trial", request->trial,
      "Run the scene and judge it. Add the effects that hold what it wants. Name its own that change nothing");
  add_wanted_option(*command, request->wanted);
  command->add_option("--out", request->out, "With --trial: file for the scene with what was added (default: none)");
  command->add_flag("--json", request->json, "Print warnings and findings as JSON");
  command->callback([request, &exit_code] {
    request->scene.notes_obstacles = true;
    exit_code = 0;
    if (names_scene(request->scene.scene)) {
      if (!check_scene_of(*request)) exit_code = exit_bad_input;
    } else {
      check_mesh_of(*request);
    }
  });
}

}  // namespace musclebench
