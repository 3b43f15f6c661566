#include "core/fibres/moment_arm.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

constexpr double radians_per_degree = std::numbers::pi / 180;

std::vector<double> angles(int count, double step_deg) {
  std::vector<double> angles;
  for (int i = 0; i < count; ++i) angles.push_back(i * step_deg * radians_per_degree);
  return angles;
}

template <typename Length>
std::vector<double> lengths(const std::vector<double>& angles, const Length& length) {
  std::vector<double> lengths;
  for (const double angle : angles) lengths.push_back(length(angle));
  return lengths;
}

/// A strap from a point fixed at distance `a` of the axis to one at distance `b` that turns: by the law of cosines
/// L^2 = a^2 + b^2 - 2 a b cos(theta), so that r = a b sin(theta) / L.
TEST(MomentArm, OfAStrapIsTheSineLaw) {
  const double a = 0.12;
  const double b = 0.05;
  const auto length = [&](double angle) { return std::sqrt(a * a + b * b - 2 * a * b * std::cos(angle + 0.5)); };
  const auto theta = angles(46, 2);
  const auto arms = moment_arms(theta, lengths(theta, length));
  for (std::size_t i = 0; i < theta.size(); ++i) {
    ASSERT_TRUE(arms[i]);
    const double wanted = a * b * std::sin(theta[i] + 0.5) / length(theta[i]);
    const bool at_an_end = i < 3 || i + 3 >= theta.size();
    EXPECT_NEAR(arms[i]->arm_m, wanted, at_an_end ? 1e-3 : 2e-4);
    // The frames' distance is the only error, and it is stated.
    EXPECT_LT(std::abs(arms[i]->arm_m - wanted), 3 * arms[i]->error_m + 1e-6);
  }
}

TEST(MomentArm, OfABandOverACylinderIsItsRadius) {
  const auto theta = angles(20, 5);
  const auto arms = moment_arms(theta, lengths(theta, [](double angle) { return 0.1 + 0.03 * angle; }));
  for (const auto& arm : arms) {
    EXPECT_NEAR(arm->arm_m, 0.03, 1e-14);
    EXPECT_LT(arm->error_m, 1e-13);
  }
}

/// Frames close together: lengths that jitter by a tenth of a millimetre would give slopes that do by 10 mm.
TEST(MomentArm, OfManyFramesIsNotTheirJitter) {
  const auto theta = angles(161, 0.5);
  std::mt19937 random(7);
  const auto arms = moment_arms(theta, lengths(theta, [&](double angle) {
                                  const double jitter_m = 1e-4 * (2 * static_cast<double>(random()) / 0xffffffff - 1);
                                  return 0.1 + 0.03 * std::sin(angle) + jitter_m;
                                }));
  double squares_m2 = 0;
  int beyond = 0;
  for (std::size_t i = 10; i + 10 < theta.size(); ++i) {
    const double off_m = arms[i]->arm_m - 0.03 * std::cos(theta[i]);
    squares_m2 += off_m * off_m;
    beyond += std::abs(off_m) > 3 * arms[i]->error_m ? 1 : 0;
  }
  EXPECT_LT(std::sqrt(squares_m2 / 141), 5e-4);
  EXPECT_LT(beyond, 14);
}

TEST(MomentArm, OfARigidTurnIsNothing) {
  const auto theta = angles(20, 5);
  for (const auto& arm : moment_arms(theta, std::vector<double>(20, 0.1))) EXPECT_EQ(arm->arm_m, 0);
}

/// There and back: each way by itself, and nothing where the bone stands still.
TEST(MomentArm, IsThatOfOneWay) {
  auto theta = angles(11, 2);
  std::vector<double> length = lengths(theta, [](double angle) { return 0.1 + 0.03 * angle; });
  for (int i = 9; i >= 0; --i) {
    theta.push_back(theta[static_cast<std::size_t>(i)]);
    length.push_back(0.11 + 0.02 * theta.back());
  }
  length[10] = 0.1 + 0.03 * theta[10];
  theta.insert(theta.end(), {0.0, 0.0, 0.0});
  length.insert(length.end(), {0.11, 0.11, 0.11});
  const auto arms = moment_arms(theta, length);
  EXPECT_NEAR(arms[10]->arm_m, 0.03, 1e-12);
  EXPECT_NEAR(arms[5]->arm_m, 0.03, 1e-12);
  EXPECT_NEAR(arms[17]->arm_m, 0.02, 1e-12);
  EXPECT_FALSE(arms[22]);
}

TEST(MomentArm, NeedsThreeSamples) {
  EXPECT_FALSE(moment_arms(angles(2, 2), std::vector<double>{0.1, 0.2})[0]);
  EXPECT_TRUE(moment_arms(angles(3, 2), std::vector<double>{0.1, 0.2, 0.3})[0]);
  EXPECT_TRUE(moment_arms({}, {}).empty());
}

/// Noise of the lengths is in the stated error: of many it covers about two thirds, as one standard error does.
TEST(MomentArm, StatesTheErrorThatNoiseMakes) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0, 1e-4);
  const auto theta = angles(2000, 0.1);
  const auto arms =
      moment_arms(theta, lengths(theta, [&](double angle) { return 0.1 + 0.03 * angle + noise(random); }));
  int within = 0;
  for (const auto& arm : arms) within += std::abs(arm->arm_m - 0.03) < arm->error_m ? 1 : 0;
  EXPECT_GT(within, 0.6 * static_cast<double>(arms.size()));
  EXPECT_LT(within, 0.9 * static_cast<double>(arms.size()));
}

}  // namespace
}  // namespace musclebench
