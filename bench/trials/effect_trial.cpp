#include "bench/trials/effect_trial.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "backends/registry.hpp"
#include "bench/cases/run_case.hpp"
#include "core/base/input_error.hpp"
#include "core/base/machine_state.hpp"

namespace musclebench {

namespace {

/// Nodes times frames: up to that, judging all frames takes a moment.
constexpr std::size_t small_scene = 100'000;
constexpr int sparsely_judged = 20;

/// Where shapes are kept: between start, middle and end, too, where a bone may be as it was at rest.
std::vector<int> shape_frames(const Scene& scene) {
  constexpr int parts = 8;
  std::set<int> frames;
  for (int part = 1; part < parts; ++part) frames.insert((part * scene.loop.frames + parts / 2) / parts);
  frames.erase(0);
  frames.erase(scene.loop.frames);
  return {frames.begin(), frames.end()};
}

/// What nothing holds may meet and leave another muscle within a few frames.
bool has_free_muscles(const Scene& scene) {
  for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
    if (!scene.muscles[muscle].velocity_m_per_s.isZero(0)) return true;
    if (std::ranges::find(scene.attachments, muscle, &Attachment::muscle) == scene.attachments.end()) return true;
  }
  return false;
}

/// Evenly over the motion, with its turn and its end; empty: all.
std::vector<int> judged_frames(const Scene& scene, const TrialRequest& request) {
  const int frames = scene.loop.frames;
  const std::size_t size = scene.muscle_mesh.vertices.size() * static_cast<std::size_t>(frames);
  const bool is_small = frames <= 2 * sparsely_judged || size <= small_scene;
  if (request.judges_all_frames || is_small || has_free_muscles(scene)) return {};
  std::set<int> judged{(frames + 1) / 2, frames};
  for (int i = 1; i <= sparsely_judged; ++i) judged.insert(frames * i / sparsely_judged);
  return {judged.begin(), judged.end()};
}

/// Why the scene can't be moved with exact depths; empty: it can.
std::string refusal_of(const Scene& scene) {
  const bool backtracks = scene.response == ResponseKind::backtrack ||
                          std::ranges::any_of(scene.bone_contacts, [](const SceneBoneContact& contact) {
                            return contact.response == ResponseKind::backtrack;
                          });
  return backtracks ? "a trial cannot use the response 'backtrack': take it out" : "";
}

/// As `--for`: what a scene chooses for a bone is not asked.
std::vector<std::string> exact_where_the_scene_chooses(const Scene& scene, const BackendEntry& exact) {
  std::vector<std::string> colliders;
  for (std::size_t i = 0; i < scene.bone_contacts.size(); ++i) {
    if (scene.bone_contacts[i].backend.name.empty()) continue;
    const std::size_t muscle = i / scene.bones.size();
    const std::string& bone = scene.bones[i % scene.bones.size()].name;
    colliders.push_back(fmt::format("{}/{}={}", scene.muscles[muscle].body.name, bone, exact.name));
  }
  return colliders;
}

EffectTrial run_once(const Scene& scene, const TrialRequest& request, const std::function<void(int)>& report) {
  const BackendEntry& backend = exact_backend();
  RunCase run{resolve_case(scene, backend, Parameters(backend.parameters, {}, backend.name),
                           {.colliders = exact_where_the_scene_chooses(scene, backend)})};
  run.judges_wishes = true;
  run.judged_frames = judged_frames(scene, request);
  // Frames that are left out pay for the others. Where none is, a trial finds what the judge of a run finds.
  if (!run.judged_frames.empty()) run.judging_effort = scene.loop.frames / static_cast<long>(run.judged_frames.size());
  run.keeps_shared = true;
  run.snapshots = shape_frames(scene);
  run.keep_surface_depths = false;
  if (request.shows_enough) {
    run.has_seen_enough = [&](const StepRecord& frame, const MuscleAtRest& rest) {
      return std::ranges::any_of(figures_of_frame(scene, frame, rest), request.shows_enough);
    };
  }
  const RunResult result = run_case(run, [&](int done) {
    if (report) report(done);
  });
  EffectTrial trial;
  trial.figures = figures_of_run(scene, result);
  trial.arms = arm_course(result.fibres);
  trial.was_stopped = result.status == "interrupted";
  trial.judged_all_frames = run.judged_frames.empty();
  trial.frames = static_cast<int>(result.records.size());
  for (const Snapshot& snapshot : result.snapshots) trial.shapes.push_back(snapshot.positions);
  if (!result.end_positions.empty()) trial.shapes.push_back(result.end_positions);
  return trial;
}

}  // namespace

EffectTrial try_effects(const Scene& scene, const TrialRequest& request, const std::function<void(int)>& report) {
  const Nanoseconds start_ns = process_cpu_ns();
  EffectTrial trial;
  trial.refusal = refusal_of(scene);
  try {
    if (trial.refusal.empty()) trial = run_once(scene, request, report);
  } catch (const InputError& refused) {
    trial.refusal = refused.what();
  }
  trial.cpu_ns = process_cpu_ns() - start_ns;
  return trial;
}

}  // namespace musclebench
