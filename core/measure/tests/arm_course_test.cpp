#include "core/measure/arm_course.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// Two fibres of a muscle whose mean grows by `arm_m` a radian over a course that slows down at both ends.
std::vector<FibreFrame> frames_of(double arm_m, int count = 60) {
  std::vector<FibreFrame> frames;
  for (int frame = 0; frame <= count; ++frame) {
    const double angle = 0.5 * (1 - std::cos(std::numbers::pi * frame / count));
    const double mean_m = 0.2 + arm_m * angle;
    frames.push_back({frame, angle, {FibreRecord{{mean_m - 0.03, mean_m + 0.03}, {}}}});
  }
  return frames;
}

TEST(ArmError, IsTheDifferenceOfTheArms) {
  const ArmCourse exact = arm_course(frames_of(0.05));
  EXPECT_NEAR(exact.mean_lengths_m[0].back(), 0.25, 1e-12);
  const ArmError none = arm_error(exact, exact);
  EXPECT_EQ(none.largest_m, 0);
  const ArmError error = arm_error(arm_course(frames_of(0.047)), exact);
  EXPECT_NEAR(error.rms_m, 0.003, 1e-9);
  EXPECT_NEAR(error.largest_m, 0.003, 1e-9);
  EXPECT_GT(error.frames, 45);
  EXPECT_LT(error.frames, 56);
}

TEST(ArmError, LooksAwayWhereTheJointTurnsBack) {
  std::vector<FibreFrame> frames = frames_of(0.05);
  frames.front().muscles[0].lengths_m[0] += 0.001;
  EXPECT_NEAR(arm_error(arm_course(frames), arm_course(frames_of(0.05))).largest_m, 0, 0.01);
  const std::vector<double> angles(61, 0.3);
  ArmCourse still = arm_course(frames_of(0.05));
  still.angles_rad = angles;
  EXPECT_EQ(arm_error(still, still).frames, 0);
}

TEST(ArmError, ComparesTheFramesThatBothHave) {
  std::vector<FibreFrame> frames = frames_of(0.047);
  frames.resize(31);
  const ArmError error = arm_error(arm_course(frames), arm_course(frames_of(0.05)));
  EXPECT_NEAR(error.rms_m, 0.003, 1e-9);
  EXPECT_LT(error.frames, 31);
}

}  // namespace
}  // namespace musclebench
