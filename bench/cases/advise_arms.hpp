#pragma once

#include <functional>
#include <optional>
#include <string>

#include "bench/cases/advice.hpp"
#include "core/measure/arm_course.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// What configurations are compared with: the moment arms of the exact run.
struct ArmInput {
  ArmCourse exact;
  int frames_run = 0;  ///< fewer than the scene has where the time was up
  double floor_m = 0;  ///< RMS error of the exact run from a start that differs by rounding
};

/// Runs the scene, which asks for fibres, exactly: twice, or once to where so many seconds of CPU time are up. Throws
/// InputError where a run diverges or is too short for a moment arm.
ArmInput run_for_arms(const Scene& scene, double seconds, const std::function<void(int frames_done)>& report);

/// What `configuration` costs, and how far it is from the exact moment arms, when it moves the muscle itself in the
/// same frames. Nothing, with the reason, where that can't be told. Throws InputError where it can't serve the scene.
std::optional<Assessment> assess_arms(const Scene& scene, const Configuration& configuration, int threads,
                                      const ArmInput& input, std::string& reason,
                                      const std::function<void(int frames_done)>& report);

}  // namespace musclebench
