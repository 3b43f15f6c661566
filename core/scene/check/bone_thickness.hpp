#pragma once

#include <vector>

#include "core/contact/bone.hpp"

namespace musclebench {

/// How thick a bone is at points of its surface: from the middle of a triangle inwards, along its normal, to where the
/// surface is left again.
struct ThicknessSample {
  double thickness_m = 0;
  double area_m2 = 0;  ///< twice that of the triangle
};

/// At some 2000 triangles whose middles are within the box. Those with nothing behind them (a hole, a sheet) have no
/// thickness and are left out.
std::vector<ThicknessSample> sample_thickness(const Bone& bone, const Eigen::AlignedBox3d& within);

/// How much of the sampled area is thinner than a length.
struct ThinShare {
  double share = 0;
  double thinnest_m = 0;  ///< 0 without samples
};

ThinShare share_thinner_than(double limit_m, const std::vector<ThicknessSample>& samples);

}  // namespace musclebench
