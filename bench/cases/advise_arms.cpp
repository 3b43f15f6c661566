#include "bench/cases/advise_arms.hpp"

#include <algorithm>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "bench/cases/advise_case.hpp"
#include "core/base/input_error.hpp"
#include "core/base/machine_state.hpp"

namespace musclebench {

namespace {

/// Rounding of coordinates of a metre changes less.
constexpr double start_noise_m = 1e-12;

RunResult run_with_exact(const Scene& scene, const std::function<bool()>& is_stopped,
                         const std::function<void(int frames_done)>& report) {
  const int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  RunResult result = run_configuration(scene, {exact_backend().name, {}}, threads, false, is_stopped, report);
  if (result.status == "diverged") {
    throw InputError(scene.name, "the exact run diverged, so there is nothing to advise on: " + result.status_detail);
  }
  return result;
}

}  // namespace

ArmInput run_for_arms(const Scene& scene, double seconds, const std::function<void(int frames_done)>& report) {
  const Nanoseconds start_ns = process_cpu_ns();
  const auto time_is_up = [&] { return static_cast<double>(process_cpu_ns() - start_ns) > seconds * 1e9; };
  const RunResult exact = run_with_exact(scene, time_is_up, report);
  ArmInput input{arm_course(exact.fibres), static_cast<int>(exact.records.size()), 0};
  if (input.frames_run < scene.loop.frames) return input;
  Scene off_by_rounding = scene;
  off_by_rounding.loop.start_noise_m = start_noise_m;
  const RunResult again = run_with_exact(off_by_rounding, [] { return false; }, {});
  const ArmError floor = arm_error(arm_course(again.fibres), input.exact);
  if (floor.frames == 0) {
    throw InputError(scene.name, fmt::format("{} frames are too few for a moment arm", input.frames_run));
  }
  input.floor_m = floor.rms_m;
  return input;
}

std::optional<Assessment> assess_arms(const Scene& scene, const Configuration& configuration, int threads,
                                      const ArmInput& input, std::string& reason,
                                      const std::function<void(int frames_done)>& report) {
  const RunResult result = run_configuration(
      scene, configuration, threads, false, [] { return false; }, report);
  if (result.status == "diverged") {
    reason = "diverged: " + result.status_detail;
    return std::nullopt;
  }
  const ArmError error = arm_error(arm_course(result.fibres), input.exact);
  std::vector<int> frames;
  std::vector<double> collision_ns;
  for (const StepRecord& record : result.records) {
    if (record.warm_up) continue;
    frames.push_back(record.frame);
    collision_ns.push_back(static_cast<double>(record.times.collision_ns()));
  }
  return Assessment{.configuration = configuration,
                    .error_m = error.rms_m,
                    .max_error_m = error.largest_m,
                    .collision_ns = block_bootstrap_median(frames, collision_ns),
                    .build_ns = result.build_ns,
                    .structure_bytes = result.structure_bytes};
}

}  // namespace musclebench
