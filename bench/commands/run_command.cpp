#include <algorithm>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/process/progress.hpp"
#include "bench/process/signals.hpp"
#include "bench/results/other_case.hpp"
#include "bench/results/result_folder.hpp"
#include "bench/results/run_output.hpp"
#include "bench/results/summary.hpp"
#include "core/measure/outcome.hpp"

namespace musclebench {

namespace {

constexpr int build_steps = 1000;

struct RunOptions {
  SceneOptions scene;
  BackendOptions backend;
  std::string out;
  int repetition = 0;
  std::vector<int> snapshots;
  bool progress_lines = false;
  bool unjudged = false;
  bool force = false;
};

std::string median_frame_ms(const std::vector<StepRecord>& records, Nanoseconds (*figure)(const StepRecord&)) {
  std::vector<Nanoseconds> values;
  for (const StepRecord& record : records) {
    if (!record.warm_up) {
      values.push_back(figure(record));
    }
  }
  return median_ms(std::move(values));
}

void print_summary(const RunCase& run, const RunResult& result, const std::string& out) {
  const std::string collision_ms = median_frame_ms(
      result.records, [](const StepRecord& r) { return r.times.update_ns + r.times.detect_ns + r.times.respond_ns; });
  const std::string frame_ms = median_frame_ms(result.records, [](const StepRecord& r) { return r.times.frame_ns; });
  const Outcome outcome = outcome_of(result.records, result.rest_volume_m3);
  fmt::print("{} with {}: {}{}{}\n", run.scene.name, run.backend.name, result.status,
             result.status_detail.empty() ? "" : ", ", result.status_detail);
  for (const Attachment& attachment : run.scene.attachments) {
    fmt::print("  attachment {:<18} {:>6} nodes on {}\n", attachment.name, attachment.nodes.size(),
               run.scene.bones[attachment.bone].name);
  }
  if (run.scene.attach_at_first_contact) {
    fmt::print("  bound at first contact        {:>6} nodes\n", result.bound_nodes.size());
  }
  fmt::print("  frames                        {:>6}\n", result.records.size());
  fmt::print("  frame, median                 {}\n", frame_ms);
  fmt::print("  of it collision               {}\n", collision_ms);
  fmt::print("  structures                    {:>10.3f} MB, built in {:.2f} s\n",
             static_cast<double>(result.structure_bytes) * 1e-6, static_cast<double>(result.build_ns) * 1e-9);
  for (const StructureError& error : result.structure_errors) {
    fmt::print("    {:<24} {:>10.3f} MB, off by {:.4f} mm (99 % of {} samples near it), at most {:.4f} mm\n",
               error.bone, static_cast<double>(error.bytes) * 1e-6, error.p99_m * 1e3, error.samples,
               error.largest_m * 1e3);
  }
  if (outcome.max_depth_m) {
    fmt::print("  largest true depth            {:>10.3f} mm, of the surface {:.3f} mm\n", *outcome.max_depth_m * 1e3,
               outcome.max_surface_depth_m.value_or(0) * 1e3);
    fmt::print("  nodes tunnelled, stuck        {:>6}, at most {} at once\n", *outcome.tunnelled_nodes,
               *outcome.stuck_nodes);
  }
  fmt::print("  state hash                    {}\n  written to {}\n", result.state_hash, out);
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
          progress.show(done);
          until_written->stop_after_frame();
        },
        [&](double share) { building->show(static_cast<int>(share * build_steps)); },
        [&] { return until_written->is_stopped(); });
  }
  const HeldSignals held;
  write_run(out, run, result);
  until_written.reset();
  return result;
}

int run(RunOptions options) {
  const BackendEntry& backend = find_backend(options.backend.backend);
  const Parameters parameters = backend_parameters(backend, options.backend.parameters);
  const Scene scene = load_scene(options.scene);
  std::sort(options.snapshots.begin(), options.snapshots.end());
  const ResponseKind response = choose_response(options.backend.response, scene, backend, parameters);
  const RunCase run_of{{scene, backend, parameters, options.backend.threads, options.repetition, response},
                       2,
                       !options.unjudged,
                       options.snapshots};
  const std::string id = run_id(run_of);
  const std::string out = options.out.empty() ? fmt::format("reports/out/runs/raw/{}", id) : options.out;
  if (!options.force && is_complete(out, id, "frames.csv")) {
    fmt::print("{} with {}: complete already in {} (--force runs it again)\n", scene.name, backend.name, out);
    return 0;
  }
  if (!options.force) {
    require_no_other_case(out, run_of, "coupled");
  }
  {
    const HeldSignals held;
    require_writable(out);
  }
  if (!options.snapshots.empty() && options.snapshots.back() > scene.loop.frames) {
    fmt::print(stderr, "musclebench: warning: --snapshots: frame {} is not among the {} frames of the run\n",
               options.snapshots.back(), scene.loop.frames);
  }

  const RunResult result = run_and_write(run_of, options, out);
  print_summary(run_of, result, out);
  if (result.status == "diverged") {
    fmt::print(stderr, "musclebench: {}: diverged: {}\n", scene.name, result.status_detail);
    return exit_diverged;
  }
  if (result.status == "interrupted") {
    fmt::print(stderr, "musclebench: {}: interrupted {}; its rows are kept\n", scene.name, result.status_detail);
    return exit_interrupted;
  }
  return 0;
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Run one case and write run.json and frames.csv");
  add_scene_options(*command, options->scene);
  add_backend_options(*command, options->backend);
  add_response_option(*command, options->backend);
  command->add_option("--out", options->out, "Result folder (default: reports/out/runs/raw/<run id>)");
  command->add_option("--repetition", options->repetition, "Number of the repetition, a part of the run's identity")
      ->check(CLI::Range(0, 1000000));
  command->add_option("--snapshots", options->snapshots, "Frames whose shape is kept, such as 0,79,157")
      ->delimiter(',')
      ->check(CLI::Range(0, 10000000));
  command->add_flag("--progress", options->progress_lines, "Print 'progress DONE TOTAL' lines on standard error");
  command->add_flag("--no-referee", options->unjudged, "Do not judge: depths, missed and false contacts stay empty");
  command->add_flag("--force", options->force, "Run even when the result is complete already");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace musclebench
