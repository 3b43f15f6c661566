#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/commands/command_options.hpp"
#include "bench/commands/commands.hpp"
#include "bench/process/progress.hpp"
#include "bench/process/signals.hpp"
#include "bench/results/other_case.hpp"
#include "bench/results/recorded_scene.hpp"
#include "bench/results/replay_output.hpp"
#include "bench/results/result_folder.hpp"
#include "bench/results/summary.hpp"
#include "core/base/input_error.hpp"
#include "core/recording/recording_reader.hpp"

namespace musclebench {

namespace {

struct ReplayOptions {
  RecordedScene recorded;
  BackendOptions backend;
  std::string out;
  double band_mm = 10;
  int stride = 1;
  int repetition = 0;
  bool progress_lines = false;
  bool bones_only = false;
  bool unjudged = false;
  bool force = false;
};

void print_accuracy(const Accuracy& accuracy, double band_m) {
  fmt::print("  missed / false contacts       {:>6} / {} (of {} true, {} answered)\n", accuracy.missed_contacts,
             accuracy.false_contacts, accuracy.true_contacts, accuracy.contacts);
  if (accuracy.depth_error_m) {
    fmt::print("  depth error, max / p99 / mean {:>10.4g} / {:.4g} / {:.4g} mm, over {} contacts within {:g} mm\n",
               accuracy.depth_error_m->max * 1e3, accuracy.depth_error_m->p99 * 1e3, accuracy.depth_error_m->mean * 1e3,
               accuracy.measured_contacts, band_m * 1e3);
  }
  if (accuracy.normal_error_deg) {
    fmt::print("  normal error                  {:>10.4g} / {:.4g} / {:.4g} degrees\n", accuracy.normal_error_deg->max,
               accuracy.normal_error_deg->p99, accuracy.normal_error_deg->mean);
  }
}

/// Where the backend believes the bones' surfaces are.
void print_offsets(const std::optional<SurfaceOffsets>& offsets, double bound_m) {
  if (!offsets || !offsets->all) return;
  const OffsetStatistics& all = *offsets->all;
  fmt::print(
      "  surface offset, p99 / max     {:>10.4g} / {:.4g} mm inwards, {:.4g} / {:.4g} mm outwards, at {} sites\n",
      all.p99_inward_m * 1e3, all.max_inward_m * 1e3, all.p99_outward_m * 1e3, all.max_outward_m * 1e3, all.sites);
  if (all.open_sites > 0) {
    fmt::print("    at {} sites the answer does not change within {:g} mm\n", all.open_sites, bound_m * 1e3);
  }
  for (std::size_t kind = 0; kind < contact_difficulties.size(); ++kind) {
    const std::optional<OffsetStatistics>& own = offsets->of_difficulties[kind];
    if (!own) continue;
    fmt::print("    {:<15}             {:>10.4g} / {:.4g} mm inwards, {:.4g} / {:.4g} mm outwards, at {} sites\n",
               contact_difficulties[kind], own->p99_inward_m * 1e3, own->max_inward_m * 1e3, own->p99_outward_m * 1e3,
               own->max_outward_m * 1e3, own->sites);
  }
}

void print_muscles(const ReplayCase& replay, const std::vector<Accuracy>& accuracy) {
  for (std::size_t i = 0; i < accuracy.size(); ++i) {
    fmt::print("  {} with bones\n", replay.scene.muscles[i].body.name);
    print_accuracy(accuracy[i], replay.band_m);
  }
}

void print_touching(const ReplayCase& replay, const MuscleReplay& muscles) {
  for (std::size_t pair = 0; pair < replay.scene.muscle_pairs.size(); ++pair) {
    std::vector<Nanoseconds> detect_ns;
    for (const MuscleReplayRecord& record : muscles.records) {
      if (!record.warm_up) detect_ns.push_back(*record.pairs[pair].detect_ns);
    }
    const auto& [first, second] = replay.scene.muscle_pairs[pair].muscles;
    fmt::print("  {} and {} by {}\n", replay.scene.muscles[static_cast<std::size_t>(first)].body.name,
               replay.scene.muscles[static_cast<std::size_t>(second)].body.name,
               replay.colliders.of_muscle_pairs[pair].entry->name);
    fmt::print("  detection a frame, median     {}\n", median_ms(std::move(detect_ns)));
    if (!muscles.accuracy.empty()) print_accuracy(muscles.accuracy[pair], replay.band_m);
  }
}

void print_summary(const ReplayCase& replay, const ReplayResult& result, const std::string& out) {
  std::vector<Nanoseconds> collision_ns;
  for (const ReplayRecord& record : result.records) {
    if (!record.warm_up) {
      collision_ns.push_back(record.collision_ns());
    }
  }
  fmt::print("{} replayed to {}: {}{}{}\n", replay.scene.name, replay.backend.name, result.status,
             result.status_detail.empty() ? "" : ", ", result.status_detail);
  fmt::print("  frames                        {:>6} of {} steps\n", result.records.size(),
             result.records.empty() ? 0 : result.records.front().iterations);
  fmt::print("  collision a frame, median     {}\n", median_ms(std::move(collision_ns)));
  fmt::print("  structures                    {:>10.3f} MB, {} in {:.2f} s\n",
             static_cast<double>(result.structure_bytes) * 1e-6, result.structures.is_from_file ? "loaded" : "built",
             static_cast<double>(result.build_ns) * 1e-9);
  print_offsets(result.offsets, replay.band_m);
  if (result.accuracy) {
    print_accuracy(*result.accuracy, replay.band_m);
  }
  print_muscles(replay, result.accuracy_of_muscles);
  if (result.muscles) print_touching(replay, *result.muscles);
  fmt::print("  contact hash                  {}\n  written to {}\n", result.contact_hash, out);
}

ReplayResult replay_and_write(const ReplayCase& replay, RecordingReader& recording, const ReplayOptions& options,
                              const std::string& out) {
  std::optional<EndAtOnce> until_written(std::in_place);
  ReplayResult result;
  {
    Progress progress(progress_style(options.progress_lines),
                      fmt::format("replay {} {}", replay.scene.name, replay.backend.name),
                      replayed_frames(replay, recording.header()));
    result = replay_case(replay, recording, [&](int done) { progress.show(done); });
  }
  const HeldSignals held;
  write_replay(out, replay, result, recording.header(), options.recorded.recording);
  until_written.reset();
  return result;
}

int replay(const ReplayOptions& options) {
  const BackendEntry& backend = find_backend(options.backend.backend);
  const Parameters parameters = backend_parameters(backend, options.backend.parameters);
  RecordingReader recording(options.recorded.recording);
  const Scene scene = load_recorded_scene(recording.header(), options.recorded);

  ColliderBackends colliders = choose_collider_backends(options.backend.colliders, scene, backend);
  if (colliders.of_faces) {
    throw InputError("--for faces",
                     "a replay asks about nodes, and the queries of faces are not recorded; leave it out");
  }
  if (options.bones_only) colliders.of_muscle_pairs.clear();
  if (!colliders.of_muscle_pairs.empty() && !recording.header().muscle_contact) {
    throw InputError(options.recorded.recording,
                     "does not hold the input of contact between muscles; record it again, or "
                     "replay contact with bones alone (--bones-only)");
  }
  const std::vector<ResponseKind> responses =
      choose_responses(options.backend.response, scene, backend, parameters, colliders);
  ReplayCase replay{{scene, backend, parameters, options.backend.threads, options.repetition, responses, colliders},
                    recording.file()};
  replay.stride = options.stride;
  replay.band_m = options.band_mm * 1e-3;
  replay.judge = !options.unjudged;
  const std::string id = replay_id(replay);
  const std::string out = options.out.empty() ? fmt::format("reports/out/runs/raw/{}", id) : options.out;
  if (!options.force && is_complete(out, id, "frames.csv")) {
    fmt::print("{} replayed to {}: complete already in {} (--force replays it again)\n", scene.name, backend.name, out);
    return 0;
  }
  if (!options.force) {
    require_no_other_case(out, replay, "replay");
  }
  {
    const HeldSignals held;
    require_writable(out);
  }
  const ReplayResult result = replay_and_write(replay, recording, options, out);
  print_summary(replay, result, out);
  if (result.status != "ok") {
    fmt::print(stderr, "musclebench: {}: {}: {}\n", scene.name, result.status, result.status_detail);
    return result.status == "suspect" ? 0 : exit_nondeterministic;
  }
  return 0;
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command =
      app.add_subcommand("replay", "Feed a recording to a backend and measure the backend's time and errors");
  command->footer(
      "Example: musclebench replay iliacus.steps --backend voxel --param cells=128\n"
      "Results: run.json and frames.csv in the folder of --out. reports/reading_results.md explains the columns.\n"
      "Exit codes: 0 done, 2 bad input, 4 the backend answers differently each time.");
  add_recorded_scene_options(*command, options->recorded)->required();
  add_backend_options(*command, options->backend);
  add_response_option(*command, options->backend);
  add_collider_option(*command, options->backend);
  command
      ->add_option("--stride", options->stride, "Replay every N-th frame, and the last frame (default: 1, every frame)")
      ->check(CLI::Range(1, 10000000));
  command
      ->add_option("--band-mm", options->band_mm,
                   "Measure errors at contacts no farther than this from the surface, mm (default: 10)")
      ->check(positive_and_finite());
  command
      ->add_option("--repetition", options->repetition, "Number of this repetition, a part of the run id (default: 0)")
      ->check(CLI::Range(0, 1000000));
  command->add_option("--out", options->out, "Result folder (default: reports/out/runs/raw/<run id>)");
  command->add_flag("--progress", options->progress_lines, "Print 'progress DONE TOTAL' lines on standard error");
  command->add_flag("--bones-only", options->bones_only, "Leave out contact between muscles");
  command->add_flag("--no-referee", options->unjudged,
                    "Measure time only: missed contacts, false contacts and errors stay empty");
  command->add_flag("--force", options->force, "Replay again even if the result is complete");
  command->callback([options, &exit_code] { exit_code = replay(*options); });
}

}  // namespace musclebench
