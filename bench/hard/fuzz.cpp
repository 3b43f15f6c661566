#include "bench/hard/fuzz.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "backends/registry.hpp"
#include "bench/cases/run_case.hpp"
#include "bench/hard/cell_process.hpp"
#include "core/base/input_error.hpp"
#include "core/measure/outcome_limits.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

/// Beside what the status promises: the limits are applied anew, to the figures of the rows.
std::string wrong_in(const Scene& scene, const BackendEntry& backend, const RunResult& result) {
  const double reach_m = 10 * scene_diagonal_m(scene);
  const bool is_whole = result.status == "ok" || result.status == "suspect";
  if (!is_whole && result.status != "diverged") return "unknown status " + result.status;
  if (is_whole && result.snapshots.empty()) return "no shape at the end";
  for (const Snapshot& snapshot : result.snapshots) {
    for (std::size_t node = 0; node < snapshot.positions.size(); ++node) {
      const double distance_m = (snapshot.positions[node] - scene.muscle_mesh.vertices[node]).norm();
      if (!(distance_m <= reach_m)) {
        return fmt::format("node {} is {} m away in frame {}, status {}", node, distance_m, snapshot.frame,
                           result.status);
      }
    }
  }
  for (const StepRecord& record : result.records) {
    if (!record.judged) continue;
    const bool are_numbers =
        std::isfinite(record.depth.max_depth_m) && std::isfinite(record.depth.mean_depth_m) &&
        std::ranges::all_of(record.volumes_m3, [](double volume) { return std::isfinite(volume); });
    if (!are_numbers) return fmt::format("frame {} has a figure that is no number", record.frame);
    if (backend.exact && record.difference.missed > 0) {
      return fmt::format("frame {}: {} contacts missed by an exact backend", record.frame, record.difference.missed);
    }
    if (result.status == "ok" && record.tunnelled_nodes > 0) {
      return fmt::format("frame {}: {} nodes tunnelled in a run that is ok", record.frame, record.tunnelled_nodes);
    }
  }
  if (result.status == "ok" && result.outcome.max_volume_error.value_or(0) > 0.05) {
    return fmt::format("the volume is off by {:.3g} in a run that is ok", *result.outcome.max_volume_error);
  }
  return "";
}

HardCell run_here(const FuzzScene& fuzz) {
  const Scene scene = read_fuzz_scene(fuzz);
  const BackendEntry& backend = find_backend(fuzz.backend);
  const Parameters parameters(backend.parameters, {}, "fuzz");
  RunCase run{{scene, backend, parameters}};
  run.responses = choose_responses("", scene, backend, parameters);
  require_what_effects_need(scene, backend, parameters, run.responses);
  run.snapshots = {0, scene.loop.frames / 2, scene.loop.frames};
  run.keep_surface_depths = false;
  const RunResult result = run_case(run, [](int) {});
  const std::string wrong = wrong_in(scene, backend, result);
  return {wrong.empty() ? Verdict::holds : Verdict::breaks, wrong.empty() ? result.status : wrong, {}};
}

}  // namespace

FuzzOutcome run_fuzz_scene(const FuzzScene& scene, double seconds) {
  const HardCell cell = run_in_process([&] { return run_here(scene); }, seconds);
  if (cell.verdict == Verdict::refused) return {.refused = cell.detail};
  if (cell.verdict == Verdict::holds) return {.status = cell.detail};
  return {.wrong = cell.detail};
}

FuzzScene shrunk(FuzzScene scene, double seconds) {
  for (bool is_smaller = true; is_smaller;) {
    is_smaller = false;
    for (FuzzScene& other : smaller_scenes(scene)) {
      if (run_fuzz_scene(other, seconds).wrong.empty()) continue;
      scene = std::move(other);
      is_smaller = true;
      break;
    }
  }
  return scene;
}

}  // namespace musclebench
