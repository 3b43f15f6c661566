#pragma once

#include <vector>

#include "core/scene/check/pose_estimates.hpp"

namespace musclebench {

/// How far a muscle's surface is compressed in itself at the estimated pose where it is so most.
struct Compression {
  std::size_t muscle = 0;
  double edge_ratio = 1;  ///< length over length at rest that 5 % of the edges are shorter than
  double angle_rad = 0;   ///< largest angle of a bone at the pose
};

/// Of each muscle.
std::vector<Compression> compressions(const Scene& scene, const PoseEstimates& poses);

}  // namespace musclebench
