// Eight boxes at a time against one after the other, on every SIMD target.
#include "core/bvh/moving_surface_boxes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include "core/base/random_numbers.hpp"
#include "core/bvh/triangle_bvh_nodes.hpp"

namespace musclebench {
namespace {

using Point = std::array<float, 3>;

class MovingBoxesTest : public testing::Test {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  float coordinate(double reach) { return static_cast<float>(reach * (2 * m_random.share() - 1)); }
  Point point() { return {coordinate(1.5), coordinate(1.5), coordinate(1.5)}; }
  MovingBoxes boxes() {
    MovingBoxes made{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t lane = 0; lane < bvh_width; ++lane) {
        const float one = coordinate(1);
        const float other = coordinate(1);
        made.lower[axis][lane] = std::min(one, other);
        made.upper[axis][lane] = std::max(one, other);
      }
    }
    return made;
  }

  RandomNumbers m_random{5};
};

TEST_F(MovingBoxesTest, DistancesAreThoseOfEachBoxAndNoSmaller) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    for (int trial = 0; trial < 300; ++trial) {
      const MovingBoxes of = boxes();
      const Point at = point();
      const float limit_m2 = 0.3F * static_cast<float>(m_random.share());
      BvhLanes squared_m2{};
      const unsigned near = find_near_boxes(of, at, limit_m2, squared_m2);
      for (std::size_t lane = 0; lane < bvh_width; ++lane) {
        float expected_m2 = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const float beyond = std::max({of.lower[axis][lane] - at[axis], at[axis] - of.upper[axis][lane], 0.0F});
          expected_m2 += beyond * beyond;
        }
        ASSERT_NEAR(squared_m2[lane], expected_m2, 1e-6F * (1 + expected_m2)) << hwy::TargetName(target);
        ASSERT_EQ((near >> lane & 1U) != 0, squared_m2[lane] <= limit_m2) << hwy::TargetName(target);
      }
    }
  }
}

TEST_F(MovingBoxesTest, ARayMeetsWhatIsAheadOfItAndWithinTheMargin) {
  constexpr float margin_m = 0.05F;
  constexpr float undecided_m = 1e-5F;  // a sum is rounded in another order here
  int met = 0;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    for (int trial = 0; trial < 600; ++trial) {
      const MovingBoxes of = boxes();
      const Point from = point();
      const int along = trial % 3;
      const bool upwards = trial % 2 == 0;
      const unsigned found = find_boxes_on_ray(of, from, along, upwards, margin_m);
      for (std::size_t lane = 0; lane < bvh_width; ++lane) {
        float room_m = 1;  // how far inside of the grown box, sideways and ahead
        for (int axis = 0; axis < 3; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          const float above_lower = from[a] - (of.lower[a][lane] - margin_m);
          const float below_upper = of.upper[a][lane] + margin_m - from[a];
          if (axis != along || !upwards) room_m = std::min(room_m, above_lower);
          if (axis != along || upwards) room_m = std::min(room_m, below_upper);
        }
        if (std::abs(room_m) < undecided_m) continue;
        ASSERT_EQ((found >> lane & 1U) != 0, room_m > 0) << hwy::TargetName(target) << ", axis " << along;
        met += room_m > 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(met, 100);
}

}  // namespace
}  // namespace musclebench
