#include "bench/cases/advise_case.hpp"

#include <algorithm>
#include <limits>
#include <thread>

#include <fmt/format.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/divergence.hpp"
#include "bench/cases/replay_case.hpp"
#include "core/base/input_error.hpp"
#include "core/base/machine_state.hpp"
#include "core/base/percentile.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

/// Enough for the interval of a median, few enough that slow backends fit into the time.
constexpr int kept_frames = 40;
constexpr int frames_in_a_row = 5;

/// In rows, as in a run: what backends know of a frame from the one before makes them faster.
bool is_kept_for_advice(const LoopParameters& loop, int frame) {
  const int stride = std::max(1, loop.frames / kept_frames);
  return (frame - 1) % (frames_in_a_row * stride) < frames_in_a_row || frame == (loop.frames + 1) / 2;
}

void step_and_keep(const Scene& scene, Simulation& simulation, int frame, KeptFrames& frames) {
  const bool kept = is_kept_for_advice(scene.loop, frame);
  const bool leads_in = !kept && is_kept_for_advice(scene.loop, frame + 1);
  if (kept) {
    frames.begin_frame(frame, scene.angle_rad(frame) * degrees_per_radian);
  } else if (leads_in) {
    frames.begin_lead_in();
  }
  simulation.step_frame(frame, kept || leads_in ? &frames : nullptr);
}

MedianEstimate collision_time(const ReplayCase& replay, const ReplayResult& result) {
  std::vector<int> frames;
  std::vector<double> collision_ns;
  for (const ReplayRecord& record : result.records) {
    if (!record.warm_up || result.records.size() <= static_cast<std::size_t>(replay.warm_up_frames)) {
      frames.push_back(record.frame);
      collision_ns.push_back(static_cast<double>(record.collision_ns()));
    }
  }
  return block_bootstrap_median(frames, collision_ns);
}

/// Of a method that can't be asked about single points: what its own motion leaves, where that takes no longer than
/// `seconds`.
bool assess_by_trial(const Scene& scene, const AssessOptions& options, Assessment& assessment, std::string& reason) {
  const double run_s = scene.loop.frames * assessment.collision_ns.median * 1e-9;
  if (run_s <= options.trial_seconds) {
    assessment.trial = try_out(scene, assessment.configuration, options.threads, options.trial_seconds, {});
  }
  if (!assessment.trial) {
    reason =
        fmt::format("it can't be asked about single points, and moving the muscle itself would take more than {:.0f} s",
                    options.trial_seconds);
    return false;
  }
  assessment.error_m = assessment.max_error_m = assessment.trial->node_depth_m;
  return true;
}

}  // namespace

void require_a_choice(const Scene& scene) {
  const auto is_settled = [](const SceneBoneContact& bone) { return !bone.backend.name.empty(); };
  if (!scene.bone_contacts.empty() && std::ranges::all_of(scene.bone_contacts, is_settled)) {
    throw InputError(scene.bone_contacts.front().backend.location,
                     "every bone has a backend of its own, so that there is nothing to choose; take one out");
  }
}

AdviceInput run_exactly(const Scene& scene, double seconds, const std::function<void(int frames_done)>& report) {
  const BackendEntry& backend = exact_backend();
  const int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const Case exact{scene, backend, Parameters(backend.parameters, {}, backend.name), threads};
  const BuiltBackend built = build_backend(exact);
  const PreparedSimulation prepared =
      prepare_simulation(exact.scene, *built.backend, exact.responses, exact.threads,
                         make_contact_methods(scene, choose_collider_backends({}, scene, backend), threads));
  const Nanoseconds start_ns = process_cpu_ns();
  AdviceInput input{std::make_unique<KeptFrames>(static_cast<int>(scene.muscle_mesh.vertices.size()),
                                                 prepared.simulation->free_nodes())};
  while (input.frames_run < scene.loop.frames && static_cast<double>(process_cpu_ns() - start_ns) < seconds * 1e9) {
    const int frame = ++input.frames_run;
    step_and_keep(scene, *prepared.simulation, frame, *input.frames);
    const std::string lost = describe_divergence(*prepared.simulation, frame);
    if (!lost.empty()) {
      throw InputError(scene.name, "the exact run diverged, so there is nothing to advise on: " + lost);
    }
    report(frame);
  }
  return input;
}

std::optional<Assessment> assess(const Scene& scene, const Configuration& configuration, const AssessOptions& options,
                                 KeptFrames& frames, std::string& reason,
                                 const std::function<void(int done, int total)>& report) {
  const BackendEntry& backend = find_backend(configuration.backend);
  const Parameters parameters(backend.parameters, configuration.parameters, configuration.text());
  ReplayCase replay{resolve_case(scene, backend, parameters, {.threads = options.threads})};
  replay.band_m = options.band_m;
  const int total = replayed_frames(replay, frames.header());
  const ReplayResult result = replay_case(replay, frames, [&](int done) { report(done, total); });
  if (result.status != "ok") {
    reason = result.status_detail;
    return std::nullopt;
  }
  const Accuracy accuracy = result.accuracy.value_or(Accuracy{});
  if (accuracy.true_contacts == 0) {
    reason = "the muscle is in no bone in these frames: there is nothing to judge";
    return std::nullopt;
  }
  Assessment assessment{
      .configuration = configuration,
      .contacts = ContactCounts{accuracy.missed_contacts, accuracy.false_contacts, accuracy.true_contacts},
      .collision_ns = collision_time(replay, result),
      .build_ns = result.build_ns,
      .structure_bytes = result.structure_bytes};
  if (!result.offsets) {
    return assess_by_trial(scene, options, assessment, reason) ? std::optional(assessment) : std::nullopt;
  }
  if (!result.offsets->all) {
    reason = "no frame ends with a node in a bone: there is nothing to judge";
    return std::nullopt;
  }
  assessment.error_m = result.offsets->all->p99_offset_m;
  assessment.max_error_m = result.offsets->all->max_offset_m;
  return assessment;
}

std::optional<Trial> try_out(const Scene& scene, const Configuration& configuration, int threads, double seconds,
                             const std::function<void(int frames_done)>& report) {
  const Nanoseconds start_ns = process_cpu_ns();
  const RunResult result = run_configuration(
      scene, configuration, threads, true,
      [&] { return static_cast<double>(process_cpu_ns() - start_ns) > seconds * 1e9; }, report);
  if (result.status == "interrupted") return std::nullopt;
  std::vector<double> frame_ns;
  for (const StepRecord& record : result.records) frame_ns.push_back(static_cast<double>(record.times.frame_ns));
  return Trial{.status = result.status,
               .status_detail = result.status_detail,
               .frames = static_cast<int>(result.records.size()),
               .node_depth_m = result.outcome.max_depth_m.value_or(std::numeric_limits<double>::quiet_NaN()),
               .surface_depth_m = result.outcome.max_surface_depth_m,
               .tunnelled_nodes = result.outcome.tunnelled_nodes.value_or(0),
               .frame_ns = frame_ns.empty() ? 0 : median(frame_ns)};
}

RunResult run_configuration(const Scene& scene, const Configuration& configuration, int threads, bool judge,
                            const std::function<bool()>& is_stopped,
                            const std::function<void(int frames_done)>& report) {
  const BackendEntry& backend = find_backend(configuration.backend);
  const Parameters parameters(backend.parameters, configuration.parameters, configuration.text());
  RunCase run{resolve_case(scene, backend, parameters, {.threads = threads})};
  run.judge = judge;
  return run_case(
      run,
      [&](int frames) {
        if (report) report(frames);
      },
      {}, is_stopped);
}

}  // namespace musclebench
