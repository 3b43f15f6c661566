#pragma once

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/bvh/triangle_bvh.hpp"

namespace musclebench {

/// `closest_on(triangle)` gives the ClosestOnTriangle of a point.
template <typename ClosestOn>
ClosestPoint closest_by_brute_force(int triangles, const ClosestOn& closest_on) {
  ClosestPoint best;
  double squared_m2 = std::numeric_limits<double>::infinity();
  for (int triangle = 0; triangle < triangles; ++triangle) {
    const ClosestOnTriangle found = closest_on(triangle);
    if (found.squared_distance_m2 < squared_m2) {
      squared_m2 = found.squared_distance_m2;
      best = {found.point, std::sqrt(squared_m2), triangle, found.feature};
    }
  }
  return best;
}

inline void expect_equal(const ClosestPoint& found, const ClosestPoint& expected) {
  EXPECT_EQ(found.triangle, expected.triangle);
  EXPECT_EQ(found.distance_m, expected.distance_m);
  EXPECT_EQ(found.point, expected.point);
  EXPECT_EQ(found.feature, expected.feature);
}

}  // namespace musclebench
