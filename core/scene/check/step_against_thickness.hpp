#pragma once

#include "core/scene/scene.hpp"

namespace musclebench {

/// How a bone's thickness compares with the farthest that a step moves it against the muscles.
struct StepAgainstThickness {
  double step_m = 0;
  int samples = 0;           ///< points of its surface near a muscle
  double thinner_share = 0;  ///< of their area, where the bone is thinner than the step
  double thinnest_m = 0;     ///< where it is thinnest among the samples; 0 without samples
};

/// Thickness is measured from the middle of a triangle inwards, along its normal, to where the surface is left again.
StepAgainstThickness step_against_thickness(const Scene& scene, std::size_t bone);

}  // namespace musclebench
