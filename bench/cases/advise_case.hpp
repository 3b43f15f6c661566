#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bench/cases/advice.hpp"
#include "bench/cases/kept_frames.hpp"
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

/// Runs the scene exactly, for at most so many seconds. Throws InputError where the run diverges.
AdviceInput run_exactly(const Scene& scene, double seconds, const std::function<void(int frames_done)>& report);

struct AssessOptions {
  double band_m = 0.01;  ///< errors count so far from a bone's surface
  int threads = 1;
};

/// What `configuration` costs and errs in these frames; bones that the scene gives a backend keep it. Nothing, with the
/// reason, where its answers can't be judged. Throws InputError where it can't serve the scene.
std::optional<Assessment> assess(const Scene& scene, const Configuration& configuration, const AssessOptions& options,
                                 KeptFrames& frames, std::string& reason,
                                 const std::function<void(int done, int total)>& report);

}  // namespace musclebench
