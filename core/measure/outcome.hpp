#pragma once

#include <optional>
#include <span>

#include "core/measure/step_record.hpp"

namespace musclebench {

/// What a backend's answers did to the muscle, over a whole run. A figure is missing where nothing was measured that it
/// could be made from.
struct Outcome {
  /// Over the judged frames, of the deepest node in a frame: the largest, and the 99th percentile by nearest rank.
  std::optional<double> max_depth_m, p99_depth_m;
  /// The same for the deepest point of a frame, of the muscle's surface in a bone or of a bone's vertex in the muscle.
  std::optional<double> max_surface_depth_m, p99_surface_depth_m;
  /// |V - V0| / V0 of the muscle's volume: the largest over all frames, and after the last one.
  std::optional<double> max_volume_error, final_volume_error;
  std::optional<int> tunnelled_nodes;  ///< most at the end of one frame
  std::optional<int> stuck_nodes;      ///< most in one frame
  Nanoseconds collision_ns = 0;        ///< update, detect and respond, sum over the run
  Nanoseconds loop_ns = 0;             ///< sum of the frames
};

/// `rest_volume_m3`: V0, of either sign.
Outcome outcome_of(std::span<const StepRecord> records, double rest_volume_m3);

}  // namespace musclebench
