#pragma once

#include <limits>

namespace musclebench {

/// Beyond these a node is lost, and so is one whose position is no number: the simulation has diverged.
struct MotionLimits {
  /// From where the node started, m.
  double range_m = std::numeric_limits<double>::infinity();
  /// Of a free node in one substep, m.
  double move_m = std::numeric_limits<double>::infinity();
};

}  // namespace musclebench
