#include "core/distance/winding_number.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "core/distance/triangle_distance.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

class WindingNumberWithEachTarget : public testing::Test {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

double sum_of_angles(const std::vector<Triangle>& triangles, const std::vector<Vec3>& vertices, const Vec3& point) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles) {
    const auto at = [&](int vertex) { return vertices[static_cast<std::size_t>(vertex)]; };
    sum += solid_angle(point, at(a), at(b), at(c));
  }
  return sum / (4 * std::numbers::pi);
}

TEST_F(WindingNumberWithEachTarget, IsTheSumOfTheAnglesAndTheSameBitsForEachTarget) {
  // Windings of -40 to 40, so that each lane turns, and, with triangles left out, of all fractions between.
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const TriangleMesh sphere = make_sphere(1, 2);
  double largest = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 direction = Vec3(uniform(generator), uniform(generator), uniform(generator)).normalized();
    const Vec3 point = (trial % 3 == 0 ? 0.98 : 1.5 * std::abs(uniform(generator))) * direction;
    std::vector<Triangle> triangles;
    for (int layer = 0; layer < (trial % 5 == 0 ? 40 : 1); ++layer) {
      for (auto [a, b, c] : sphere.triangles) {
        if (trial % 4 == 0 && uniform(generator) < 0.3) continue;
        if (trial % 2 == 0) std::swap(b, c);
        triangles.push_back({a, b, c});
      }
    }
    // All lanes there are, and some.
    triangles.resize(triangles.size() - static_cast<std::size_t>(trial) % 9);
    const double truth = sum_of_angles(triangles, sphere.vertices, point);
    std::vector<double> found;
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      found.push_back(winding_number(triangles, sphere.vertices, point));
    }
    EXPECT_NEAR(found.front(), truth, 1e-11) << trial;
    EXPECT_EQ(found, std::vector<double>(found.size(), found.front())) << trial;
    largest = std::max(largest, std::abs(truth));
  }
  EXPECT_GT(largest, 25);
}

TEST(WindingNumber, IsZeroOfNoTriangleAndInThePlaneOfOne) {
  const std::vector<Vec3> corners = {Vec3::UnitX(), Vec3::UnitY(), Vec3::Zero()};
  const std::vector<Triangle> triangle = {{0, 1, 2}};
  EXPECT_EQ(winding_number({}, {}, Vec3::Zero()), 0);
  EXPECT_EQ(winding_number(triangle, corners, Vec3(0.2, 0.3, 0)), 0);
  EXPECT_EQ(winding_number(triangle, corners, Vec3::UnitX()), 0);
}

TEST(WindingNumber, IsThatOfAPartAloneWhereLanesAreLeftOver) {
  const TriangleMesh sphere = make_sphere(1, 2);
  for (std::size_t count = 1; count < 20; ++count) {
    const std::vector<Triangle> some(sphere.triangles.begin(),
                                     sphere.triangles.begin() + static_cast<std::ptrdiff_t>(count));
    const Vec3 point(0.1, 0.2, -0.3);
    EXPECT_NEAR(winding_number(some, sphere.vertices, point), sum_of_angles(some, sphere.vertices, point), 1e-14)
        << count;
  }
}

TEST(WindingNumber, IsANumberForFarPointsAndTinySurfaces) {
  TriangleMesh sphere = make_sphere(1, 2);
  EXPECT_NEAR(winding_number(sphere.triangles, sphere.vertices, Vec3(1e100, 0, 0)), 0, 1e-9);
  for (Vec3& vertex : sphere.vertices) vertex *= 1e-80;
  EXPECT_NEAR(winding_number(sphere.triangles, sphere.vertices, Vec3::Zero()), 1, 1e-12);
}

}  // namespace
}  // namespace musclebench
