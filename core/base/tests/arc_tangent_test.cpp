#include "core/base/arc_tangent.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// The C library's atan2l is right to 64 bits of mantissa.
TEST(ArcTangent, IsRightToTwoAndAHalfUnitsInTheLastPlace) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> exponent(-60, 60);
  std::uniform_real_distribution<double> unit(-1, 1);
  double largest = 0;
  for (int i = 0; i < 400'000; ++i) {
    const double y = unit(random) * (i % 2 == 0 ? 1 : std::exp2(exponent(random)));
    const double x = unit(random);
    const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
    const auto nearest = static_cast<double>(std::abs(exact));
    const double unit_in_last_place = std::nextafter(nearest, std::numeric_limits<double>::infinity()) - nearest;
    largest = std::max(largest, static_cast<double>(std::abs(arc_tangent2(y, x) - exact)) / unit_in_last_place);
  }
  EXPECT_LT(largest, 2.5);
  EXPECT_GT(largest, 0.4);
}

TEST(ArcTangent, HasTheQuadrantsAndTheZeroOfTheLibrary) {
  for (const double y : {0.0, -0.0, 1e-300, -1e-300, 1.0, -1.0, 2.0, -2.0}) {
    for (const double x : {0.0, 1e-300, -1e-300, 1.0, -1.0, 0.41421356237309503, -0.41421356237309503}) {
      if (x == 0 && y == 0) continue;
      EXPECT_DOUBLE_EQ(arc_tangent2(y, x), std::atan2(y, x)) << y << ", " << x;
      EXPECT_EQ(std::signbit(arc_tangent2(y, x)), std::signbit(y)) << y << ", " << x;
    }
  }
  EXPECT_EQ(arc_tangent2(0.0, 0.0), 0.0);
}

}  // namespace
}  // namespace musclebench
