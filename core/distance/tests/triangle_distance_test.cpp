#include "core/distance/triangle_distance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <tuple>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

Vec3 random_point(std::mt19937& generator) {
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const double x = coordinate(generator);
  const double y = coordinate(generator);
  return {x, y, coordinate(generator)};
}

/// The smallest distance over a fine barycentric lattice: never below the true distance.
double sampled_distance(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  constexpr int steps = 200;
  double smallest = 1e300;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps - i; ++j) {
      const double v = static_cast<double>(i) / steps;
      const double w = static_cast<double>(j) / steps;
      smallest = std::min(smallest, (point - (a + v * (b - a) + w * (c - a))).norm());
    }
  }
  return smallest;
}

TEST(ClosestOnTriangle, AnswersEachFeature) {
  const Vec3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  const auto expect = [&](const Vec3& point, const Vec3& closest, Feature feature) {
    const ClosestOnTriangle found = closest_on_triangle(point, a, b, c);
    EXPECT_NEAR((found.point - closest).norm(), 0, 1e-15) << point.transpose();
    EXPECT_DOUBLE_EQ(found.squared_distance_m2, (point - closest).squaredNorm());
    EXPECT_EQ(found.feature, feature) << point.transpose();
  };
  expect({1, 1, 3}, {1, 1, 0}, Feature::face);
  expect({2, -1, 1}, {2, 0, 0}, Feature::edge_0);
  expect({3, 3, -1}, {2, 2, 0}, Feature::edge_1);
  expect({-2, 1, 0}, {0, 1, 0}, Feature::edge_2);
  expect({-1, -1, 1}, a, Feature::corner_0);
  expect({6, -1, 0}, b, Feature::corner_1);
  expect({-1, 7, 0}, c, Feature::corner_2);
}

TEST(ClosestOnTriangle, IsNeverBeatenByASample) {
  std::mt19937 generator(7);
  for (int i = 0; i < 50; ++i) {
    const Vec3 a = random_point(generator), b = random_point(generator), c = random_point(generator);
    const Vec3 point = 2 * random_point(generator);
    const ClosestOnTriangle found = closest_on_triangle(point, a, b, c);
    const double distance = std::sqrt(found.squared_distance_m2);
    const double sampled = sampled_distance(point, a, b, c);
    EXPECT_LE(distance, sampled + 1e-15);
    EXPECT_GE(distance, sampled - 0.02);
    EXPECT_NEAR((point - found.point).norm(), distance, 1e-15);
  }
}

TEST(ClosestOnTriangle, TakesDegenerateTrianglesAsSegmentsAndPoints) {
  const Vec3 a(1, 2, 3), b(2, 2, 3), c(4, 2, 3), point(2.5, 3, 3);
  for (const auto& [p, q, r] : {std::tuple{a, b, c}, {b, a, c}, {c, b, a}, {a, c, c}, {c, c, a}, {c, a, c}}) {
    EXPECT_DOUBLE_EQ(closest_on_triangle(point, p, q, r).squared_distance_m2, 1);
  }
  EXPECT_DOUBLE_EQ(closest_on_triangle(point, a, a, a).squared_distance_m2, (point - a).squaredNorm());
  EXPECT_DOUBLE_EQ(closest_on_triangle(a, a, a, a).squared_distance_m2, 0);
}

TEST(ClosestOnTriangle, StaysExactOnSlivers) {
  // A sliver of aspect 1e7 seen from far away: the foot must stay on it.
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0.5, 1e-7, 0), point(0.3, 0.2e-7, 100);
  EXPECT_NEAR(std::sqrt(closest_on_triangle(point, a, b, c).squared_distance_m2), 100, 1e-12);
}

TEST(SolidAngle, SumsToTheWholeSphereInsideAndToNothingOutside) {
  const TriangleMesh sphere = make_sphere(1, 2);
  const auto sum = [&](const Vec3& point) {
    double angle = 0;
    for (const Triangle& t : sphere.triangles) {
      angle +=
          solid_angle(point, sphere.vertices[static_cast<std::size_t>(t[0])],
                      sphere.vertices[static_cast<std::size_t>(t[1])], sphere.vertices[static_cast<std::size_t>(t[2])]);
    }
    return angle;
  };
  EXPECT_NEAR(sum({0.5, 0.2, -0.6}), 4 * std::numbers::pi, 1e-10);
  EXPECT_NEAR(sum({0.9, 0.9, 0}), 0, 1e-10);
}

TEST(SolidAngle, OfAnOctantIsAnEighth) {
  const double octant = solid_angle(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ());
  EXPECT_NEAR(octant, std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(solid_angle(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitX(), Vec3::UnitZ()), 0);
}

}  // namespace
}  // namespace musclebench
