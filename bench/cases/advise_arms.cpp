#include "bench/cases/advise_arms.hpp"

#include <algorithm>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "bench/cases/run_case.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

/// Rounding of coordinates of a metre changes less.
constexpr double start_noise_m = 1e-12;

RunResult run_unjudged(const Scene& scene, const BackendEntry& backend, const Parameters& parameters, int threads,
                       const std::function<bool(int frames_done)>& is_last,
                       const std::function<void(int frames_done)>& report) {
  const ColliderBackends colliders = choose_collider_backends({}, scene, backend);
  const std::vector<ResponseKind> responses = choose_responses("", scene, backend, parameters, colliders);
  require_what_effects_need(scene, backend, parameters, responses, colliders);
  RunCase run{{scene, backend, parameters, threads, 0, responses, colliders}};
  run.judge = false;
  int done = 0;
  return run_case(
      run, [&](int frames) { report(done = frames); }, {}, [&] { return is_last(done); });
}

RunResult run_with_exact(const Scene& scene, const std::function<bool(int frames_done)>& is_last,
                         const std::function<void(int frames_done)>& report) {
  const BackendEntry& backend = exact_backend();
  const int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  RunResult result =
      run_unjudged(scene, backend, Parameters(backend.parameters, {}, backend.name), threads, is_last, report);
  if (result.status == "diverged") {
    throw InputError(scene.name, "the exact run diverged, so there is nothing to advise on: " + result.status_detail);
  }
  return result;
}

}  // namespace

ArmInput run_for_arms(const Scene& scene, double seconds, const std::function<void(int frames_done)>& report) {
  const Nanoseconds start_ns = monotonic_now_ns();
  const auto time_is_up = [&](int /*frames_done*/) {
    return static_cast<double>(monotonic_now_ns() - start_ns) > 0.5 * seconds * 1e9;
  };
  const RunResult exact = run_with_exact(scene, time_is_up, report);
  ArmInput input{arm_course(exact.fibres), static_cast<int>(exact.records.size()), 0};
  Scene off_by_rounding = scene;
  off_by_rounding.loop.start_noise_m = start_noise_m;
  const auto are_as_many = [&](int frames_done) { return frames_done >= input.frames_run; };
  const RunResult again = run_with_exact(off_by_rounding, are_as_many, [](int /*frames*/) {});
  const ArmError floor = arm_error(arm_course(again.fibres), input.exact);
  if (floor.frames == 0) {
    throw InputError("--seconds", fmt::format("{} frames of the exact run are too few for a moment arm; give more time",
                                              input.frames_run));
  }
  input.floor_m = floor.rms_m;
  return input;
}

std::optional<Assessment> assess_arms(const Scene& scene, const Configuration& configuration, int threads,
                                      const ArmInput& input, std::string& reason,
                                      const std::function<void(int frames_done)>& report) {
  const BackendEntry& backend = find_backend(configuration.backend);
  const Parameters parameters(backend.parameters, configuration.parameters, configuration.text());
  const RunResult result = run_unjudged(
      scene, backend, parameters, threads, [&](int frames_done) { return frames_done >= input.frames_run; }, report);
  if (result.status == "diverged") {
    reason = "diverged: " + result.status_detail;
    return std::nullopt;
  }
  const ArmError error = arm_error(arm_course(result.fibres), input.exact);
  std::vector<double> collision_ns;
  for (const StepRecord& record : result.records) {
    if (!record.warm_up) collision_ns.push_back(static_cast<double>(record.times.collision_ns()));
  }
  return Assessment{
      configuration,   error.rms_m,           error.largest_m, std::nullopt, median_interval(collision_ns),
      result.build_ns, result.structure_bytes};
}

}  // namespace musclebench
