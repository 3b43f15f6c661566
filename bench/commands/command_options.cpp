#include "bench/commands/command_options.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/commands/effect_trials.hpp"
#include "bench/process/progress.hpp"
#include "core/base/input_error.hpp"
#include "core/scene/check/scene_check.hpp"
#include "core/scene/read_motion.hpp"
#include "core/scene/scene_warnings.hpp"

namespace musclebench {

void add_scene_options(CLI::App& command, SceneOptions& options) {
  command.add_option("scene", options.choice.scene, "Scene: a name that `musclebench list` prints, or a .toml file")
      ->required();
  command.add_option("--preset", options.choice.preset, "Loop and effects: paper or standard (default: the scene's)");
  command.add_option("--loop", options.loop, "Loop parameter key=value; overrides scene and preset; may be repeated");
  command.add_option("--motion", options.motion,
                     "Motion of the turning bones: from_deg=, to_deg= or "
                     "course=there|there_and_back|rest_first|rest_to_rest; overrides the scene");
  command.add_option("--meshes", options.meshes,
                     "Finer meshes: split_muscles=TIMES or smooth_bones=TIMES; overrides the scene; may be repeated");
  command.add_option("--data", options.choice.data, "Folder of the anatomical data (default: $MUSCLEBENCH_DATA)");
  command
      .add_option("--frames", options.frames,
                  "Frames over which the whole motion is spread (default: the scene's or preset's)")
      ->check(CLI::Range(1, 10000000));
}

CLI::Option* add_recorded_scene_options(CLI::App& command, RecordedScene& options) {
  command.add_option("--scene", options.scene,
                     "Name or file of the recorded scene (default: the name or path in the recording)");
  command.add_option("--data", options.data, "Folder of the anatomical data (default: $MUSCLEBENCH_DATA)");
  return command.add_option("recording", options.recording, "File that `musclebench record` wrote");
}

std::map<std::string, ParameterValue> loop_overrides(const SceneOptions& options) {
  std::map<std::string, ParameterValue> overrides;
  if (options.frames > 0) {
    overrides["frames"] = std::int64_t{options.frames};
  }
  for (const auto& [key, value] : parse_assignments(options.loop, "--loop", loop_parameters())) {
    overrides[key] = value;
  }
  return overrides;
}

SceneChoice choice_of(const SceneOptions& options) {
  SceneChoice choice = options.choice;
  choice.loop_overrides = loop_overrides(options);
  choice.mesh_overrides = parse_assignments(options.meshes, "--meshes", mesh_parameters());
  choice.motion_overrides = parse_assignments(options.motion, "--motion", motion_parameters());
  return choice;
}

Scene load_scene(const SceneOptions& options) {
  SceneChoice choice = choice_of(options);
  std::optional<Progress> progress;
  choice.check_report = [&](int done, int total) {
    if (!progress) progress.emplace(progress_style(false), "check " + choice.scene, total);
    progress->show(done);
  };
  Scene scene = load_scene(choice);
  progress.reset();
  scene.warnings = warnings_of(scene);
  if (!waits_for_trials(scene)) print_warnings(scene.name, scene.warnings);
  for (const AddedEffect& added : scene.auto_effects.added) {
    fmt::print(stderr, "musclebench: {}: added {} [{}]: {}\n", scene.name, added.effect, added.rule, added.reason);
  }
  return scene;
}

void print_warnings(const std::string& scene, const std::vector<SceneWarning>& warnings) {
  for (const SceneWarning& warning : warnings) {
    fmt::print(stderr, "musclebench: warning: {}: {}\n", scene, warning.text);
  }
}

void add_backend_options(CLI::App& command, BackendOptions& options) {
  command.add_option("--backend", options.backend, "Collision backend; `musclebench list` names all")->required();
  command.add_option("--param", options.parameters,
                     "Backend parameter key=value; may be repeated (default: the values of `musclebench list`)");
  add_threads_option(command, options.threads);
}

void add_response_option(CLI::App& command, BackendOptions& options) {
  command.add_option(
      "--response", options.response,
      "How contact moves nodes out of bones: backtrack or project (default: the scene's, else the backend's)");
}

void add_collider_option(CLI::App& command, BackendOptions& options) {
  command.add_option(
      "--for", options.colliders,
      "COLLIDER=BACKEND[:key=value,...]: another backend for one collider; may be repeated. COLLIDER is BONE, "
      "MUSCLE/BONE, MUSCLE/MUSCLE, `muscles` for all muscles that touch, or `faces` for surface_contact with bones");
}

void add_threads_option(CLI::App& command, int& threads) {
  command.add_option("--threads", threads, "Threads of loop and backend (default: 1)")
      ->check(CLI::Validator(
          [](const std::string& text) {
            long wanted = 0;
            return CLI::detail::lexical_cast(text, wanted) ? refusal_of_threads(wanted) : std::string();
          },
          ""));
}

Parameters backend_parameters(const BackendEntry& backend, const std::vector<std::string>& assignments) {
  Parameters parameters(backend.parameters, parse_assignments(assignments, "--param", backend.parameters),
                        fmt::format("--param ({})", backend.name));
  (void)backend.make(parameters);  // refuses what does not go together, before anything is read
  return parameters;
}

CLI::Validator positive_and_finite() {
  return CLI::Validator(
      [](const std::string& text) {
        double value = 0;
        const bool is_number = CLI::detail::lexical_cast(text, value);
        return is_number && std::isfinite(value) && value > 0 ? std::string()
                                                              : text + " is not a positive, finite number";
      },
      "POSITIVE");
}

}  // namespace musclebench
