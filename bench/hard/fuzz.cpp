#include "bench/hard/fuzz.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "backends/registry.hpp"
#include "bench/cases/collider_backends.hpp"
#include "bench/cases/run_case.hpp"
#include "bench/hard/cell_process.hpp"
#include "core/base/input_error.hpp"
#include "core/measure/outcome_limits.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

/// By which a bone's surface may move in a second, m; twice that is the most that it can throw a body at.
double fastest_bone_m_per_s(const Scene& scene) {
  const LoopParameters& loop = scene.loop;
  double fastest_m = 0;  // a frame
  std::vector<RigidMotion> before, after;
  scene.poses_at(0, before);
  for (int frame = 1; frame <= loop.frames; ++frame, before.swap(after)) {
    scene.poses_at(frame, after);
    for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
      const Eigen::AlignedBox3d box = bounding_box(scene.bones[bone].surface.mesh.vertices);
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 at = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
        fastest_m = std::max(fastest_m, (after[bone].apply(at) - before[bone].apply(at)).norm());
      }
    }
  }
  // Where bones jump once a frame, they do so in one substep.
  return fastest_m / (loop.time_step_s * (loop.interpolate_poses ? loop.substeps : 1));
}

Vec3 gravity_of(const Scene& scene) {
  const auto gravity = std::ranges::find(scene.effects, "gravity", &SceneEffect::name);
  if (gravity == scene.effects.end()) return Vec3::Zero();
  const Parameters& given = gravity->parameters;
  return {given.number("x_m_per_s2"), given.number("y_m_per_s2"), given.number("z_m_per_s2")};
}

/// How far bodies may fly in `time_s` with nothing wrong: g t (t + h) / 2 + 2 v t, what falls from a bone that threw
/// it. A substep h adds its whole gain of speed at its beginning.
double farthest_flight_m(const Scene& scene, double time_s) {
  return 0.5 * gravity_of(scene).norm() * time_s * (time_s + scene.loop.time_step_s) +
         2 * fastest_bone_m_per_s(scene) * time_s;
}

/// A body that nothing holds, and that had the time to fly as far or as fast: its end out there is right. A muscle is
/// held by a bound node, where edges hold the others.
bool may_have_flown_out(const Scene& scene, const RunResult& result) {
  const bool is_any_free =
      !has_effect(scene, "edge_length") || std::ranges::any_of(scene.muscles, [&](const Muscle& muscle) {
        return std::ranges::none_of(result.bound_nodes,
                                    [&](const BoundNode& bound) { return muscle.body.has_node(bound.node); });
      });
  const double time_s = scene.loop.time_s(result.records.back().frame, scene.loop.substeps);
  const double step_m = (gravity_of(scene).norm() * time_s + 2 * fastest_bone_m_per_s(scene)) * scene.loop.time_step_s;
  const MotionLimits limits = motion_limits(scene);
  return is_any_free && (farthest_flight_m(scene, time_s) >= limits.range_m || step_m >= limits.move_m);
}

/// Beside what the status promises: the limits are applied anew, to the figures of the rows.
std::string wrong_in(const Scene& scene, const BackendEntry& backend, const RunResult& result) {
  const double reach_m = 10 * scene_diagonal_m(scene);
  const bool is_whole = result.status == "ok" || result.status == "suspect";
  if (!is_whole && result.status != "diverged") return "unknown status " + result.status;
  if (!is_whole && !may_have_flown_out(scene, result)) return "diverged: " + result.status_detail;
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
  const bool is_exact = backend.exact && std::ranges::all_of(scene.bone_contacts, [](const SceneBoneContact& bone) {
                          return bone.backend.name.empty();
                        });
  for (const StepRecord& record : result.records) {
    if (!record.judged) continue;
    const bool are_numbers =
        std::isfinite(record.depth.max_depth_m) && std::isfinite(record.depth.mean_depth_m) &&
        std::ranges::all_of(record.volumes_m3, [](double volume) { return std::isfinite(volume); });
    if (!are_numbers) return fmt::format("frame {} has a figure that is no number", record.frame);
    if (is_exact && record.difference.missed > 0) {
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
  RunCase run{resolve_case(scene, backend, parameters)};
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
