#pragma once

#include <optional>

#include "core/contact/muscle_contact.hpp"
#include "core/scene/check/pose_estimates.hpp"

namespace musclebench {

/// How near two muscles come to each other.
struct MuscleGap {
  MusclePair muscles;
  /// At rest, of the nodes of either to the surface of the other, exact: the smallest distance, negative inside.
  double rest_m = 0;
  int rest_nodes_inside = 0;
  /// The same over all estimated poses, rest among them.
  double least_m = 0;
  double least_angle_rad = 0;  ///< largest angle of a bone there
};

/// Of all pairs of muscles whose boxes come within `reach_m` at some pose.
std::vector<MuscleGap> muscle_gaps(const Scene& scene, const PoseEstimates& poses, double reach_m);

}  // namespace musclebench
