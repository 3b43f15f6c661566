#pragma once

#include <optional>
#include <span>
#include <vector>

namespace musclebench {

/// The change of a muscle's length with the angle of a joint, r = dL / d(theta) (virtual work, An et al. 1984).
struct MomentArm {
  double arm_m = 0;    ///< positive where the muscle grows longer as the angle grows
  double error_m = 0;  ///< one standard error, see moment_arms
};

/// The moment arm at each of the samples of a motion: the slope of the parabola that fits the lengths of the nearest
/// seven samples best, or of all within 5 degrees where they are more (Savitzky and Golay 1964), because a slope over
/// less is that of the frames' jitter. They lie within a part of the motion in which the angle only grows or only
/// falls; there is nothing where that part has fewer than three samples or the angle stands still. Of two parts a
/// sample in which the motion turns belongs to the first.
///
/// The error is that of the slope by the samples' scatter about the parabola, and, for what the angle between samples
/// hides, by how far the slope differs from that over five sevenths of the samples.
std::vector<std::optional<MomentArm>> moment_arms(std::span<const double> angles_rad,
                                                  std::span<const double> lengths_m);

}  // namespace musclebench
