#include "core/fibres/mean_value_coordinates.hpp"

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "core/fibres/tests/bent_bar.hpp"

namespace musclebench {
namespace {

Vec3 carried(const std::vector<double>& weights, const std::vector<Vec3>& values) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * values[i];
  return sum;
}

std::vector<Vec3> mapped(const std::vector<Vec3>& points, const Mat3& linear, const Vec3& shift) {
  std::vector<Vec3> result;
  for (const Vec3& point : points) result.emplace_back(linear * point + shift);
  return result;
}

void expect_affine(const TriangleMesh& mesh, const Vec3& point) {
  Mat3 linear;
  linear << 1.5, -0.4, 0.2, 0.3, 0.7, -1.1, -0.6, 0.1, 2.0;
  const Vec3 shift(0.3, -0.2, 0.9);
  const std::vector<double> weights = mean_value_coordinates(mesh, point);
  ASSERT_EQ(weights.size(), mesh.vertices.size());
  EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1, 1e-13);
  const double error = (carried(weights, mapped(mesh.vertices, linear, shift)) - (linear * point + shift)).norm();
  EXPECT_LT(error, 1e-14);
}

TEST(MeanValueCoordinates, ReproduceAffineMapsToRounding) {
  expect_affine(make_sphere(0.1, 3), Vec3(0.03, 0.02, -0.05));
  expect_affine(make_sphere(0.1, 3), Vec3(0, 0, 0.0985));
  const auto bar = test::bent_bar(test::make_bar(0.2, 0.01, 6), 0.05, 1.5 * std::numbers::pi);
  expect_affine(bar.mesh, Vec3(0.05, 0.001, 0.002));
  expect_affine(bar.mesh, Vec3(0, 0.0599, 0.009));
}

/// The published form cannot do that by itself: the weights of an open surface do not balance.
TEST(MeanValueCoordinates, ReproduceAffineMapsInAnOpenSurface) {
  TriangleMesh open = make_sphere(0.1, 2);
  open.triangles.resize(open.triangles.size() - 20);
  expect_affine(open, Vec3(0.03, 0.02, -0.05));
}

/// Of four points no other weights reproduce affine functions.
TEST(MeanValueCoordinates, OfATetrahedronAreBarycentric) {
  TriangleMesh tetrahedron{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 2, 0), Vec3(0.3, 0.2, 1.5)},
                           {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  const Eigen::Vector4d wanted(0.1, 0.2, 0.3, 0.4);
  Vec3 point = Vec3::Zero();
  for (int i = 0; i < 4; ++i) point += wanted[i] * tetrahedron.vertices[static_cast<std::size_t>(i)];
  const std::vector<double> weights = mean_value_coordinates(tetrahedron, point);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(weights[static_cast<std::size_t>(i)], wanted[i], 1e-14);
}

/// Where a ray from the point leaves the box.
Vec3 exit_of_box(const Vec3& point, const Vec3& direction, const Vec3& half) {
  double nearest = 1e300;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) continue;
    const double wall = direction[axis] > 0 ? half[axis] : -half[axis];
    nearest = std::min(nearest, (wall - point[axis]) / direction[axis]);
  }
  return point + nearest * direction;
}

/// The definition: the mean over all directions of the surface's value there, weighted by 1 / distance. A cubic value
/// at the vertices, linear between them, is no affine function.
TEST(MeanValueCoordinates, AreTheMeanOverAllDirections) {
  const Vec3 half(0.7, 0.5, 0.4);
  const TriangleMesh box = make_box(half, 8);
  const auto function = [](const Vec3& p) { return p.x() * p.x() * p.y() + 2 * p.z() * p.z(); };
  const Vec3 point(0.2, -0.1, 0.15);
  const std::vector<double> weights = mean_value_coordinates(box, point);
  double found = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) found += weights[i] * function(box.vertices[i]);
  double sum = 0;
  double total = 0;
  constexpr int samples = 200'000;  // a Fibonacci sphere
  for (int i = 0; i < samples; ++i) {
    const double z = 1 - (2 * i + 1.0) / samples;
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    const Vec3 hit = exit_of_box(point, Vec3(r * std::cos(angle), r * std::sin(angle), z), half);
    const double weight = 1 / (hit - point).norm();
    sum += weight * function(hit);
    total += weight;
  }
  // The box's function is linear between vertices 0.0875 to 0.175 m apart: that much is left.
  EXPECT_NEAR(found, sum / total, 4e-3);
  EXPECT_GT(std::abs(sum / total - function(point)), 0.05);
}

TEST(MeanValueCoordinates, AreNoneOfAFlatSheet) {
  const TriangleMesh sheet{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{0, 1, 2}}};
  EXPECT_TRUE(mean_value_coordinates(sheet, Vec3(0.2, 0.2, 0)).empty());
}

}  // namespace
}  // namespace musclebench
