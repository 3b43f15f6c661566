#pragma once

#include "core/scene/check/bone_thickness.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// How a bone's thickness near the muscles compares with the farthest that a step moves it against them.
struct StepAgainstThickness {
  double step_m = 0;
  ThinShare thinner = {};  ///< than the step
};

StepAgainstThickness step_against_thickness(const Scene& scene, std::size_t bone);

/// That of all muscles at rest, and a tenth of its diagonal more on all sides.
Eigen::AlignedBox3d box_near_muscles(const Scene& scene);

}  // namespace musclebench
