#include "core/measure/arm_course.hpp"

#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "core/mesh/rigid_motion.hpp"

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

TEST(ArmError, HasTheNumbersOfThePythonTools) {
  std::ifstream file(ARM_ERROR_CASES);
  std::string line;
  std::getline(file, line);
  std::string word;
  double rms_mm = 0;
  double largest_mm = 0;
  int frames = 0;
  file >> word >> rms_mm >> largest_mm >> frames;
  ASSERT_EQ(word, "rms_max_frames_mm");
  while (word != "exact_arm_mm") ASSERT_TRUE(file >> word);
  ArmCourse ours{{}, {{}}};
  ArmCourse exact{{}, {{}}};
  std::vector<double> arms_mm;
  double angle_deg = 0;
  double ours_mm = 0;
  double exact_mm = 0;
  double arm_mm = 0;
  for (int frame = 0; file >> frame >> angle_deg >> ours_mm >> exact_mm >> arm_mm >> word;) {
    ours.angles_rad.push_back(angle_deg / degrees_per_radian);
    ours.mean_lengths_m[0].push_back(1e-3 * ours_mm);
    exact.mean_lengths_m[0].push_back(1e-3 * exact_mm);
    arms_mm.push_back(arm_mm);
  }
  exact.angles_rad = ours.angles_rad;
  ASSERT_EQ(arms_mm.size(), 31);
  const auto arms = moment_arms(ours.angles_rad, ours.mean_lengths_m[0]);
  for (std::size_t i = 0; i < arms.size(); ++i) EXPECT_NEAR(1e3 * arms[i]->arm_m, arms_mm[i], 1e-6) << i;
  const ArmError error = arm_error(ours, exact);
  EXPECT_NEAR(1e3 * error.rms_m, rms_mm, 1e-6);
  EXPECT_NEAR(1e3 * error.largest_m, largest_mm, 1e-6);
  EXPECT_EQ(error.frames, frames);
}

}  // namespace
}  // namespace musclebench
