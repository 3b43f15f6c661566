#pragma once

#include <span>
#include <vector>

#include "core/measure/fibre_record.hpp"

namespace musclebench {

/// Mean fibre lengths of each muscle over a run, from which its moment arms follow.
struct ArmCourse {
  std::vector<double> angles_rad;                   ///< by frame; the first at rest
  std::vector<std::vector<double>> mean_lengths_m;  ///< by muscle, then by frame
};

ArmCourse arm_course(std::span<const FibreFrame> frames);

struct ArmError {
  double rms_m = 0;
  double largest_m = 0;
  int frames = 0;  ///< that were compared, of all muscles
};

/// How far the moment arms of a course are from those of another over the same angles, in the frames in which the joint
/// turns at least a quarter as fast as at its fastest: where it turns back a slope over the angle tells little.
ArmError arm_error(const ArmCourse& course, const ArmCourse& exact);

}  // namespace musclebench
