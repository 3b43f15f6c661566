#include "bench/hard/moved_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

double largest_gap_m(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  double largest_m = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    // Not std::max: it passes over NaN.
    const double moved_m = (to[i] - from[i]).norm();
    if (!(moved_m <= largest_m)) largest_m = moved_m;
  }
  return largest_m;
}

std::string MovedScene::said() const {
  return result.status == "ok" ? "" : fmt::format("{}: {}", result.status, result.status_detail);
}

double MovedScene::tunnelled_nodes() const {
  const std::optional<int>& nodes = result.outcome.tunnelled_nodes;
  return nodes && result.status != "diverged" ? *nodes : std::nan("");
}

double MovedScene::diagonal_m() const { return bounding_box(scene.muscle_mesh.vertices).diagonal().norm(); }

double MovedScene::jitter_m(std::size_t frame) const {
  std::vector<Vec3> middles;
  for (std::size_t i = 0; i < positions(frame).size(); ++i) {
    middles.emplace_back(0.5 * (positions(frame - 1)[i] + positions(frame + 1)[i]));
  }
  return largest_gap_m(positions(frame), middles);
}

SceneChoice scene_of(const std::string& name) {
  SceneChoice choice;
  choice.scene = name;
  return choice;
}

MovedScene moved(const HardRequest& request, Scene scene, int threads,
                 const std::function<void(int frames_done)>& after_frame) {
  if (request.spoil) request.spoil(scene);
  MovedScene done{std::move(scene), {}};
  const Parameters parameters = request.parameters();
  RunCase run{resolve_case(done.scene, request.backend, parameters, {.threads = threads})};
  run.snapshots.resize(static_cast<std::size_t>(done.scene.loop.frames) + 1);
  std::iota(run.snapshots.begin(), run.snapshots.end(), 0);
  run.forces = true;
  run.keep_surface_depths = false;  // a shape is kept of each frame: they would take as long as the run
  done.result = run_case(run, after_frame);
  return done;
}

MovedScene moved(const HardRequest& request, const SceneChoice& choice, int threads, const EditScene& edit) {
  Scene scene = load_scene(choice);
  if (edit) edit(scene);
  return moved(request, std::move(scene), threads);
}

void reverse_bones(Scene& scene) {
  std::ranges::reverse(scene.bones);
  std::ranges::reverse(scene.bone_meshes);
  std::ranges::reverse(scene.motions);
}

HardFigure without_contact(const std::vector<StepRecord>& records, const std::string& words) {
  const bool found = std::ranges::any_of(records, [](const StepRecord& record) { return record.contacts > 0; });
  return {(words.empty() ? "" : words + ": ") + "runs without a contact", found ? 0.0 : 1.0, 0};
}

namespace {

/// The largest over the bones; 0 where nothing is declared.
double largest_bound_m(const MovedScene& run, const HardRequest& request, double (*of)(const AnswerBound&)) {
  const auto backend = request.backend.make(request.parameters());
  backend->build(run.scene.bones, run.scene.muscle_mesh, 1);
  double largest_m = 0;
  for (std::size_t bone = 0; bone < run.scene.bones.size(); ++bone) {
    largest_m = std::max(largest_m, of(backend->answer_bound(static_cast<int>(bone))));
  }
  return std::isfinite(largest_m) ? largest_m : 0;
}

}  // namespace

double declared_m(const MovedScene& run, const HardRequest& request) {
  return largest_bound_m(
      run, request, [](const AnswerBound& bound) { return std::max(bound.missed_depth_m, bound.false_distance_m); });
}

double declared_missed_m(const MovedScene& run, const HardRequest& request) {
  return largest_bound_m(run, request, [](const AnswerBound& bound) { return bound.missed_depth_m; });
}

}  // namespace musclebench
