#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bench/cases/advice.hpp"
#include "bench/cases/kept_frames.hpp"
#include "bench/cases/run_case.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// What the configurations of an advice are asked about: frames of a run with the exact backend, in rows that are
/// spread evenly over the motion, and its deepest bend.
struct AdviceInput {
  std::unique_ptr<KeptFrames> frames;
  int frames_run = 0;  ///< fewer than the scene has where the time was up
};

/// Throws InputError where every bone of the scene has a backend of its own: there is nothing to choose.
void require_a_choice(const Scene& scene);

/// Runs the scene exactly, for at most so many seconds of CPU time. Throws InputError where the run diverges.
AdviceInput run_exactly(const Scene& scene, double seconds, const std::function<void(int frames_done)>& report);

struct AssessOptions {
  double band_m = 0.01;  ///< errors count so far from a bone's surface
  int threads = 1;
  double trial_seconds = 30;  ///< CPU time of the trial of a method that can't be asked about single points
};

/// What `configuration` costs in these frames, and how far its surface is from the true one at their contacts; bones
/// that the scene gives a backend keep it. Nothing, with the reason, where its answers can't be judged. Throws
/// InputError where it can't serve the scene.
std::optional<Assessment> assess(const Scene& scene, const Configuration& configuration, const AssessOptions& options,
                                 KeptFrames& frames, std::string& reason,
                                 const std::function<void(int done, int total)>& report);

/// Moves the muscle by `configuration` over the whole motion, judged in every frame. Nothing where that takes more than
/// `seconds` of CPU time. Throws InputError where it can't serve the scene. `report` may be empty.
std::optional<Trial> try_out(const Scene& scene, const Configuration& configuration, int threads, double seconds,
                             const std::function<void(int frames_done)>& report);

/// The run behind a trial.
RunResult run_configuration(const Scene& scene, const Configuration& configuration, int threads, bool judge,
                            const std::function<bool()>& is_stopped,
                            const std::function<void(int frames_done)>& report);

}  // namespace musclebench
