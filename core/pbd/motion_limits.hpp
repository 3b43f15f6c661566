#pragma once

#include <limits>

namespace musclebench {

/// Limits of a node's motion. A node beyond a limit is lost, and so is a node whose position is not a number: the
/// simulation has diverged.
struct MotionLimits {
  /// Largest distance from the node's initial position, m.
  double range_m = std::numeric_limits<double>::infinity();
  /// Largest displacement of a free node in one substep, m.
  double move_m = std::numeric_limits<double>::infinity();
};

}  // namespace musclebench
