#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace musclebench {

/// Effects that the scene calls for and lacks, one line each: what was found, the figure behind it, the line to add.
/// Costs some milliseconds for each bone near a muscle. Empty when nothing is lacking.
std::vector<std::string> scene_advice(const Scene& scene);

/// How a bone's thickness compares with the farthest that a step moves it against the muscles.
struct StepAgainstThickness {
  double step_m = 0;
  int samples = 0;        ///< points of its surface near a muscle
  int thinner = 0;        ///< of these, where the bone is thinner than the step
  double thinnest_m = 0;  ///< where it is thinnest among the samples; 0 without samples
};

/// Thickness is measured from the middle of a triangle inwards, along its normal, to where the surface is left again.
StepAgainstThickness step_against_thickness(const Scene& scene, std::size_t bone);

}  // namespace musclebench
