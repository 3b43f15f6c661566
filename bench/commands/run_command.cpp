#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/commands/effect_options.hpp"
#include "bench/commands/effect_trials.hpp"
#include "bench/process/progress.hpp"
#include "bench/process/signals.hpp"
#include "bench/results/other_case.hpp"
#include "bench/results/recording_header_of.hpp"
#include "bench/results/result_folder.hpp"
#include "bench/results/run_output.hpp"
#include "bench/results/summary.hpp"
#include "core/base/input_error.hpp"
#include "core/base/output_file.hpp"
#include "core/recording/recording_writer.hpp"

namespace musclebench {

namespace {

constexpr int build_steps = 1000;

struct RunOptions {
  SceneOptions scene;
  EffectOptions effects;
  std::vector<std::string> wanted;
  BackendOptions backend;
  std::string out;
  int repetition = 0;
  std::vector<int> snapshots;
  bool progress_lines = false;
  bool unjudged = false;
  bool force = false;
  bool self_intersections = false;
  bool strict = false;
  bool unpruned = false;
  bool forces = false;
  int fibres = -1;              ///< below 0: the scene's
  int fibres_if_possible = -1;  ///< the same
};

constexpr const char* before_divergence = "before_divergence.recording";

std::vector<int> free_nodes(const RunCase& run, const RunResult& result) {
  std::vector<int> nodes;
  auto bound = result.bound_nodes.begin();
  for (int node = 0; node < static_cast<int>(run.scene.muscle_mesh.vertices.size()); ++node) {
    while (bound != result.bound_nodes.end() && bound->node < node) ++bound;
    if (bound == result.bound_nodes.end() || bound->node != node) nodes.push_back(node);
  }
  return nodes;
}

/// The frames before a divergence, as a recording for `replay`, and beside it the scene with all that the command line
/// changed in it. False for none, or where a position can't be stored.
bool write_last_steps(const std::filesystem::path& file, const RunCase& run, const RunOptions& options,
                      const RunResult& result) {
  if (result.last_steps.empty()) return false;
  const int last = result.records.back().frame - 1;
  const int frames = static_cast<int>(result.last_steps.size()) / (run.scene.loop.substeps * run.scene.loop.iterations);
  SceneChoice as_resolved;
  as_resolved.scene = std::filesystem::path(file).replace_extension(".toml").string();
  OutputFile scene(as_resolved.scene);
  scene.stream() << resolved_scene(choice_of(options.scene), run.scene);
  scene.close();
  RecordingWriter writer(file, recording_header(run, as_resolved, {last - frames + 1, last}, free_nodes(run, result)));
  for (const RecordedStep& step : result.last_steps) {
    if (!writer.add_step(step.substep_start, step.previous_bone_poses, step.positions, step.bone_poses,
                         step.muscle_positions)) {
      return false;
    }
  }
  writer.finish();
  return true;
}

RunResult run_and_write(const RunCase& run, const RunOptions& options, const std::string& out) {
  std::optional<EndAtOnce> until_written(std::in_place);
  RunResult result;
  {
    Progress progress(progress_style(options.progress_lines), fmt::format("{} {}", run.scene.name, run.backend.name),
                      run.scene.loop.frames);
    // Of a build only people want to know; programs count frames.
    auto building =
        std::make_unique<Progress>(options.progress_lines ? Progress::Style::none : progress_style(false),
                                   fmt::format("{} {}: building", run.scene.name, run.backend.name), build_steps);
    result = run_case(
        run,
        [&](int done) {
          building.reset();
          until_written->stop_and_keep();  // before a program reads of a frame and may send its signal
          progress.show(done);
        },
        [&](double share) { building->show(static_cast<int>(share * build_steps)); },
        [&] { return until_written->is_stopped(); });
  }
  note_unmet_wants(run, result);
  const HeldSignals held;
  write_run(out, run, result);
  if (write_last_steps(std::filesystem::path(out) / before_divergence, run, options, result)) {
    fmt::print(stderr,
               "musclebench: {}: the collision steps of the frames before are in {}/{}, for `musclebench replay`\n",
               run.scene.name, out, before_divergence);
  }
  until_written.reset();
  return result;
}

void print_pruned_part(const Scene& scene, const std::string& bone, const PrunedResult& each) {
  const std::string kept =
      fmt::format("musclebench: {}: over bone '{}' {:.0f} % of the grid were built, as far as muscles are expected",
                  scene.name, bone, 100 * each.pruned.kept_share);
  if (each.frame_back) {
    fmt::print(stderr, "{}; in frame {} a node came elsewhere, and all of it was built in {:.3g} ms\n", kept,
               *each.frame_back, 1e-6 * static_cast<double>(each.pruned.build_ns));
  } else {
    fmt::print(stderr, "{}\n", kept);
  }
}

void print_pruned(const Scene& scene, const RunResult& result) {
  for (const PrunedResult& each : result.pruned) {
    const Bone& bone = scene.bones[static_cast<std::size_t>(each.pruned.bone)];
    if (each.pruned.kept_share > 0) {
      print_pruned_part(scene, bone.name, each);
      continue;
    }
    const std::string expected = fmt::format(
        "musclebench: {}: bone '{}' was pruned, {:.3g} mm from where muscles are expected ({:.3g} mm would do)",
        scene.name, bone.name, 1e3 * each.reach.distance_m, 1e3 * each.reach.margin_m);
    if (each.frame_back) {
      fmt::print(stderr, "{}; in frame {} a node came near it, and it was built in {:.3g} ms\n", expected,
                 *each.frame_back, 1e-6 * static_cast<double>(each.pruned.build_ns));
    } else {
      fmt::print(stderr, "{}: no structure over its {} triangles, {} queries less\n", expected,
                 bone.surface.mesh.triangles.size(), each.pruned.saved_queries);
    }
  }
}

/// Says why a run is suspect. The exit code of one that went to its end, now or before.
int conclude(std::string_view scene, std::string_view status, std::string_view status_detail, bool strict) {
  if (status != "suspect") {
    return 0;
  }
  fmt::print(stderr, "musclebench: {}: suspect: {}\n", scene, status_detail);
  return strict ? exit_not_held : 0;
}

/// A signal waits until the folder that this tries out is gone again.
void require_writable_with_signals_held(const std::string& out) {
  const HeldSignals held;
  require_writable(out);
}

/// What is wrong with the command is said before a search for effects takes its time.
void check_options(const RunOptions& options, const BackendEntry& backend, const Parameters& parameters,
                   const Scene& scene) {
  const ColliderBackends colliders = choose_collider_backends(options.backend.colliders, scene, backend);
  (void)choose_responses(options.backend.response, scene, backend, parameters, colliders);
  if (!options.out.empty()) require_writable_with_signals_held(options.out);
}

struct Ran {
  int code = 0;
  bool is_suspect = false;
  bool was_there = false;  ///< an earlier command wrote the result
  /// The folder of results has another case, and a search of all frames may have led to that.
  bool was_put_off = false;
};

/// Which pass of a command it is: of a scene that asks for effects there may be two.
struct Pass {
  bool may_show_more = false;  ///< the search judged some frames only, and called all held
  bool replaces = false;       ///< what the pass before wrote may be another case
};

Ran run_scene(Scene scene, const BackendEntry& backend, const Parameters& parameters, const RunOptions& options,
              const Pass& pass) {
  RunCase run_of{
      resolve_case(scene, backend, parameters,
                   {options.backend.response, options.backend.colliders, options.backend.threads, options.repetition})};
  run_of.judge = !options.unjudged;
  const std::vector<SceneWarning> added = warnings_of_run(run_of);
  print_warnings(scene.name, added);
  scene.warnings.insert(scene.warnings.end(), added.begin(), added.end());
  run_of.judges_wishes = !scene.wanted.own_values.empty();
  run_of.snapshots = options.snapshots;
  run_of.count_self_intersections = options.self_intersections;
  run_of.prune = !options.unpruned;
  run_of.forces = options.forces;
  const std::string id = run_id(run_of);
  const std::string out = options.out.empty() ? fmt::format("reports/out/runs/raw/{}", id) : options.out;
  if (const auto stored = options.force ? std::nullopt : complete_result(out, id, "frames.csv")) {
    fmt::print("{} with {}: complete already in {} (--force runs it again)\n", scene.name, backend.name, out);
    return {conclude(scene.name, stored->status, stored->status_detail, options.strict), stored->status == "suspect",
            true};
  }
  if (!options.force && pass.may_show_more && std::filesystem::exists(std::filesystem::path(out) / "run.json")) {
    return {.was_put_off = true};
  }
  if (!options.force && !pass.replaces) {
    require_no_other_case(out, run_of, "coupled");
  }
  require_writable_with_signals_held(out);
  if (!options.snapshots.empty() && options.snapshots.back() > scene.loop.frames) {
    fmt::print(stderr, "musclebench: warning: --snapshots: frame {} is not among the {} frames of the run\n",
               options.snapshots.back(), scene.loop.frames);
  }

  const RunResult result = run_and_write(run_of, options, out);
  print_pruned(scene, result);
  if (!result.fibres_refused.empty()) {
    fmt::print(stderr, "musclebench: warning: no fibres are followed: {}\n", result.fibres_refused);
  }
  if (const std::string why = result.force_obstacles.text(); !why.empty()) {
    fmt::print(stderr, "musclebench: warning: some forces mean nothing and are left out: {}\n", why);
  }
  fmt::print("{}  written to {}\n", run_summary(run_of, result), out);
  if (result.status == "diverged") {
    fmt::print(stderr, "musclebench: {}: diverged: {}\n", scene.name, result.status_detail);
    return {exit_diverged};
  }
  if (result.status == "interrupted") {
    fmt::print(stderr, "musclebench: {}: interrupted {}; its rows are kept\n", scene.name, result.status_detail);
    return {exit_interrupted};
  }
  return {conclude(scene.name, result.status, result.status_detail, options.strict), result.status == "suspect"};
}

int run(RunOptions options) {
  if (options.strict && options.unjudged) {
    throw InputError("--strict",
                     "asks for outcomes within their limits, and --no-referee leaves most of them unjudged; "
                     "leave one of the two out");
  }
  const BackendEntry& backend = find_backend(options.backend.backend);
  const Parameters parameters = backend_parameters(backend, options.backend.parameters);
  options.scene.choice.effect_overrides = effect_overrides(options.effects);
  if (options.fibres >= 0) options.scene.choice.fibres = {options.fibres, "--fibres"};
  if (options.fibres_if_possible >= 0) {
    options.scene.choice.fibres = {options.fibres_if_possible, "--fibres-if-possible", false};
  }
  options.scene.choice.wanted_overrides = wanted_overrides(options.wanted);
  std::sort(options.snapshots.begin(), options.snapshots.end());
  const auto search = [&](Scene& scene, bool judges_the_end) {
    return add_wanted_effects(choice_of(options.scene), scene,
                              {options.force, judges_the_end,
                               [&](const Scene& widest) { check_options(options, backend, parameters, widest); }});
  };
  Scene scene = load_scene(options.scene);
  const bool may_show_more = search(scene, false) && !options.unjudged;
  const std::vector<AddedEffect> added = scene.auto_effects.added;
  const Ran ran = run_scene(std::move(scene), backend, parameters, options, {.may_show_more = may_show_more});
  if (!may_show_more || !(ran.is_suspect || ran.was_put_off)) return ran.code;
  Scene again = load_scene(options.scene);
  fmt::print(stderr, "musclebench: {}: trials judged some frames only{}: all frames now\n", again.name,
             ran.was_put_off ? "" : ", and the run is suspect");
  search(again, true);
  // What holds in all frames with exact contacts, and is suspect, has a backend that errs.
  const bool is_same =
      std::ranges::equal(again.auto_effects.added, added, {}, &AddedEffect::effect, &AddedEffect::effect);
  if (is_same && !ran.was_put_off) return ran.code;
  return run_scene(std::move(again), backend, parameters, options, {.replaces = !ran.was_put_off && !ran.was_there})
      .code;
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command =
      app.add_subcommand("run", "Run a scene with one backend, measure time and memory, and judge the result");
  command->footer(
      "Example: musclebench run synthetic/iliacus --backend sdf --param cells=128\n"
      "Results: run.json and frames.csv in the folder of --out. reports/reading_results.md explains the columns.\n"
      "Exit codes: 0 done, 1 suspect (with --strict only), 2 bad input, 3 diverged.");
  add_scene_options(*command, options->scene);
  add_effect_options(*command, options->effects);
  add_backend_options(*command, options->backend);
  add_response_option(*command, options->backend);
  add_collider_option(*command, options->backend);
  command
      ->add_option_function<std::string>(
          "--effects", [options](const std::string& /*auto*/) { options->scene.choice.auto_effects = true; },
          "auto: also add the effects that the scene lacks, as `musclebench check` finds. With [wanted] or --wanted, "
          "trial runs find them")
      ->check(CLI::IsMember({"auto"}));
  add_wanted_option(*command, options->wanted);
  command->add_option("--out", options->out, "Result folder (default: reports/out/runs/raw/<run id>)");
  command
      ->add_option("--repetition", options->repetition, "Number of this repetition, a part of the run id (default: 0)")
      ->check(CLI::Range(0, 1000000));
  command
      ->add_option("--snapshots", options->snapshots,
                   "Frames whose shapes are stored, such as 0,79,157 (default: none)")
      ->delimiter(',')
      ->check(CLI::Range(0, 10000000));
  command->add_flag("--progress", options->progress_lines, "Print 'progress DONE TOTAL' lines on standard error");
  command->add_flag("--no-referee", options->unjudged,
                    "Do not judge the run: depths, missed and false contacts stay empty");
  command->add_flag("--self-intersections", options->self_intersections,
                    "With --no-referee: count triangles that intersect others at rest, in the frames of --snapshots "
                    "and in the last frame");
  CLI::Option* fibres =
      command
          ->add_option("--fibres", options->fibres,
                       "Fibres to follow in each muscle, for lengths and moment arms (default: the scene's, or none)")
          ->check(CLI::Range(0, 100000));
  command
      ->add_option("--fibres-if-possible", options->fibres_if_possible,
                   "Like --fibres, but where a scene cannot have fibres, run without them and say why (default: off)")
      ->check(CLI::Range(0, 100000))
      ->excludes(fibres);
  command->add_flag(
      "--forces", options->forces,
      "Write the forces of contacts, attachments, retinacula and joints of every frame into forces.csv, and the "
      "pressure on nodes into snapshots (takes time in each frame)");
  command->add_flag("--strict", options->strict,
                    "Exit with code 1 if the run ends `suspect`: an outcome is beyond a limit of `musclebench list`");
  command->add_flag("--no-pruning", options->unpruned,
                    "Build structures for all bones, also for bones that no muscle is expected to touch");
  command->add_flag("--force", options->force,
                    "Run again even if the result is complete, and search for effects again");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace musclebench
