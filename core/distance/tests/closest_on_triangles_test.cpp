#include "core/distance/closest_on_triangles.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace musclebench {
namespace {

std::uint64_t bits(double value) {
  std::uint64_t result = 0;
  std::memcpy(&result, &value, sizeof(value));
  return result;
}

class ClosestOnTrianglesWithEachTarget : public testing::Test {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

/// Triangles of all kinds, slivers, segments and single points too, and points about them, on their corners, edges and
/// faces as well.
TEST_F(ClosestOnTrianglesWithEachTarget, AreThoseOfEachPairToTheBit) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal(0, 1);
  std::uniform_int_distribution<int> kind(0, 5);
  const auto anywhere = [&] {
    const double x = normal(generator), y = normal(generator);
    return Vec3(x, y, normal(generator));
  };
  std::vector<std::array<Vec3, 3>> corners;
  for (int t = 0; t < 400; ++t) {
    const Vec3 a = anywhere() + (t % 7 == 0 ? Vec3(1e4, -1e3, 1e5) : Vec3(Vec3::Zero()));
    const Vec3 along = std::pow(10.0, 2 * normal(generator)) * anywhere();
    const double thin = std::array{1.0, 1e-3, 1e-9, 1e-13, 1e-16, 0.0}[static_cast<std::size_t>(kind(generator))];
    const double share = t % 3 == 0 ? 0.5 : normal(generator);
    const Vec3 c = a + share * along + thin * along.norm() * anywhere();
    corners.push_back({a, t % 50 == 0 ? a : Vec3(a + along), t % 100 == 0 ? a : c});
  }
  std::vector<Vec3> points;
  for (std::size_t p = 0; p < 4000; ++p) {
    const auto& [a, b, c] = corners[p % corners.size()];
    const double v = kind(generator) / 3.0 - 0.5;
    const double w = kind(generator) / 3.0 - 0.5;
    const double away = kind(generator) == 0 ? 0 : (b - a).norm() * std::pow(10.0, 2 * normal(generator));
    points.push_back(a + v * (b - a) + w * (c - a) + away * anywhere());
  }
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    std::vector<std::int32_t> point;
    std::vector<std::int32_t> triangle;
    for (std::size_t p = 0; p < points.size(); ++p) {
      point.push_back(static_cast<std::int32_t>(p));
      // Half of the points meet the triangle that they were made about.
      triangle.push_back(static_cast<std::int32_t>((p + (p % 2) * 17) % corners.size()));
    }
    constexpr std::size_t width = ClosestOnTriangles::width;
    std::vector<ClosestOnTriangles> found(points.size() / width);
    closest_on_triangles(points.data(), corners.data(), point, triangle, found);
    for (std::size_t p = 0; p < points.size(); ++p) {
      const auto& [a, b, c] = corners[static_cast<std::size_t>(triangle[p])];
      const ClosestOnTriangle expected = closest_on_triangle(points[p], a, b, c);
      const ClosestOnTriangle actual = found[p / width].at(p % width);
      ASSERT_EQ(bits(actual.squared_distance_m2), bits(expected.squared_distance_m2)) << target;
      ASSERT_EQ(actual.point, expected.point) << target;
      ASSERT_EQ(actual.feature, expected.feature) << target;
    }
  }
}

}  // namespace
}  // namespace musclebench
