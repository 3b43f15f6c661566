#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/cases/run_case.hpp"
#include "bench/cases/scene_source.hpp"
#include "bench/hard/hard_case.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

/// Between a node's two places, m; NaN where one has got lost.
double largest_gap_m(const std::vector<Vec3>& from, const std::vector<Vec3>& to);

/// A scene of the hard cases after its run, every frame of it kept.
struct MovedScene {
  Scene scene;
  RunResult result;

  /// What the run's status says; empty for one that is ok.
  [[nodiscard]] std::string said() const;
  [[nodiscard]] double diagonal_m() const;
  /// Most of them after a frame; NaN of a run that diverged or that nobody judged.
  [[nodiscard]] double tunnelled_nodes() const;
  [[nodiscard]] const std::vector<Vec3>& positions(std::size_t frame) const {
    return result.snapshots.at(frame).positions;
  }
  /// The largest move of a node between two frames.
  [[nodiscard]] double largest_move_m(std::size_t from, std::size_t to) const {
    return largest_gap_m(positions(from), positions(to));
  }
  /// The largest distance of a node from the middle of where it was before the frame and where it is after it: 0 for
  /// one that still creeps to its place, its amplitude for one that is thrown to and fro.
  [[nodiscard]] double jitter_m(std::size_t frame) const;
};

/// Puts the bones into the other order. For scenes without attachments.
void reverse_bones(Scene& scene);

/// An embedded scene as it is.
SceneChoice scene_of(const std::string& name);

using EditScene = std::function<void(Scene&)>;

/// Runs the scene as `musclebench run` does; `after_frame`, which may throw, is called after each frame. Throws
/// InputError where the backend can't serve its effects.
MovedScene moved(
    const HardRequest& request, Scene scene, int threads = 1,
    const std::function<void(int frames_done)>& after_frame = [](int) {});

/// The scene of the choice, which `edit` changes first. Throws InputError as above and where it can't be read.
MovedScene moved(const HardRequest& request, const SceneChoice& choice, int threads = 1, const EditScene& edit = {});

/// Runs without a contact compare nothing: a bar of 0 for those of a case that holds two runs against each other.
HardFigure without_contact(const std::vector<StepRecord>& records, const std::string& words = "");

/// How far out of its place a backend that approximates may push a node that lies on a bone. One that promises nothing
/// is held to what exact ones are: its figures are the result.
double declared_m(const MovedScene& run, const HardRequest& request);
/// How deep it may leave a node that it misses: no bound outwards widens a bar inwards.
double declared_missed_m(const MovedScene& run, const HardRequest& request);

/// Why a run was not made, or not to its end.
struct TakesTooLong : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What `watch` says. A scene whose effects the backend can't serve, or that takes too long with it, is not for it.
template <typename Watch>
HardCell watched(const HardRequest& request, bool asks_backend, const Watch& watch) {
  if (request.backend.make(request.parameters())->capabilities().finds_contacts != asks_backend) {
    return not_applicable(asks_backend ? "finds no contacts" : "asks the loop alone: see the column `loop`");
  }
  try {
    return watch();
  } catch (const InputError& unfit) {
    return not_applicable(unfit.what());
  } catch (const TakesTooLong& slow) {
    return not_applicable(slow.what());
  }
}

}  // namespace musclebench
