#include "core/contact/least_displacement.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

HalfSpaces half_spaces(const std::vector<HalfSpace>& given) {
  HalfSpaces all;
  for (const HalfSpace& each : given) all.add(each);
  return all;
}

/// Violated by no more than the softness leaves.
void expect_outside(const HalfSpaces& all, const Vec3& displacement, double share = 1e-7) {
  double deepest_m = 0;
  for (const HalfSpace& each : all) deepest_m = std::max(deepest_m, each.depth_m);
  for (const HalfSpace& each : all) {
    EXPECT_GE(each.normal.dot(displacement), each.depth_m - share * deepest_m);
  }
}

TEST(LeastDisplacement, OfOneIsItsDepthAlongItsNormal) {
  const Vec3 normal = Vec3(1, 2, -2) / 3;
  EXPECT_LT((least_displacement(half_spaces({{normal, 0.002}})) - 0.002 * normal).norm(), 1e-11);
  EXPECT_EQ(least_displacement(half_spaces({{normal, -0.002}})), Vec3::Zero());
  EXPECT_EQ(least_displacement({}), Vec3::Zero());
}

/// Out of a wedge of any angle: to the edge where the sides meet, or to the side that is enough.
TEST(LeastDisplacement, OutOfAWedgeItIsTheShortestWay) {
  for (int degrees = 5; degrees < 180; degrees += 5) {
    const double angle_rad = degrees * std::numbers::pi / 180;  // between the normals
    const Vec3 left = Vec3::UnitZ();
    const Vec3 right(std::sin(angle_rad), 0, std::cos(angle_rad));
    const HalfSpaces wedge = half_spaces({{left, 0.001}, {right, 0.0008}});
    const Vec3 found = least_displacement(wedge);
    const double cosine = left.dot(right);
    Vec3 expected = 0.001 * left;
    if (expected.dot(right) < 0.0008) {
      const double along_right = (0.0008 - 0.001 * cosine) / (1 - cosine * cosine);
      expected = (0.001 - along_right * cosine) * left + along_right * right;
    }
    EXPECT_LT((found - expected).norm(), 1e-7 * expected.norm() / (1 - std::abs(cosine))) << degrees;
    expect_outside(wedge, found, 2e-9 / (1 - cosine * cosine) + 1e-9);
  }
}

TEST(LeastDisplacement, BonesThatOverlapPushOnce) {
  const Vec3 normal = Vec3::UnitY();
  const Vec3 found = least_displacement(half_spaces({{normal, 0.003}, {normal, 0.003}, {normal, 0.001}}));
  EXPECT_LT((found - 0.003 * normal).norm(), 1e-11);
}

/// Between two bones that close on it the node is in the middle.
TEST(LeastDisplacement, WhatHasNoRoomSharesTheDepth) {
  for (const double gap_m : {2e-3, 1e-6, -1e-6, -1e-3}) {
    const Vec3 found = least_displacement(half_spaces({{Vec3::UnitX(), 1e-3}, {-Vec3::UnitX(), -1e-3 - gap_m}}));
    EXPECT_NEAR(found.x(), gap_m > 0 ? 1e-3 : 1e-3 + gap_m / 2, 1e-10) << gap_m;
    EXPECT_LT(std::hypot(found.y(), found.z()), 1e-15);
  }
}

/// At random: outside, and nothing near that is outside, too, is shorter, which is enough in a convex set.
TEST(LeastDisplacement, IsShortestAndOutsideAndOfNoOrder) {
  std::mt19937 random(4);
  std::normal_distribution<double> component;
  std::uniform_real_distribution<double> depth_m(-0.001, 0.004);
  for (int trial = 0; trial < 3000; ++trial) {
    std::vector<HalfSpace> given(1 + static_cast<std::size_t>(trial % 6));
    const Vec3 open = Vec3(component(random), component(random), component(random)).normalized();
    for (HalfSpace& each : given) {
      do {  // all of them hold far enough along one direction
        each.normal = Vec3(component(random), component(random), component(random)).normalized();
      } while (each.normal.dot(open) < 0.2);
      each.depth_m = depth_m(random);
    }
    const HalfSpaces all = half_spaces(given);
    const Vec3 found = least_displacement(all);
    expect_outside(all, found);
    for (int sample = 0; sample < 50; ++sample) {
      const Vec3 other = found + 1e-3 * Vec3(component(random), component(random), component(random));
      const bool is_outside =
          std::ranges::all_of(given, [&](const HalfSpace& each) { return each.normal.dot(other) >= each.depth_m; });
      EXPECT_TRUE(!is_outside || other.norm() >= found.norm() * (1 - 1e-7));
    }
    std::ranges::reverse(given);
    EXPECT_EQ(least_displacement(half_spaces(given)), found);
  }
}

/// Bones of equal depth: which comes first must not show in the last bits.
TEST(LeastDisplacement, OfEqualDepthsHasNoOrder) {
  std::mt19937 random(7);
  std::normal_distribution<double> component;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<HalfSpace> given(4);
    for (HalfSpace& each : given) {
      each.normal = (Vec3(component(random), component(random), component(random)).normalized() + Vec3::UnitZ());
      each.normal.normalize();
      each.depth_m = 0.001;
    }
    const Vec3 found = least_displacement(half_spaces(given));
    for (int turn = 0; turn < 4; ++turn) {
      std::rotate(given.begin(), given.begin() + 1, given.end());
      ASSERT_EQ(least_displacement(half_spaces(given)), found) << "trial " << trial;
    }
  }
}

}  // namespace
}  // namespace musclebench
