#include "core/mesh/shapes.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "core/mesh_repair/check_mesh.hpp"

namespace musclebench {
namespace {

constexpr double pi = std::numbers::pi;

void expect_closed_outward(const TriangleMesh& mesh) {
  const MeshReport report = check_mesh(mesh);
  EXPECT_EQ(describe(report).front(), "no defects");
  EXPECT_EQ(report.components, 1);
  EXPECT_GT(report.volume_m3, 0);
  // Euler's formula of a sphere-like surface: V - E + F = 2 with E = 3 F / 2.
  EXPECT_EQ(2 * report.vertices - report.triangles, 4);
}

TEST(Shapes, SphereHasItsFormulasFigures) {
  const double radius_m = 0.024;
  double previous_error = 1;
  for (int subdivisions = 0; subdivisions <= 4; ++subdivisions) {
    const TriangleMesh mesh = make_sphere(radius_m, subdivisions);
    ASSERT_EQ(mesh.triangles.size(), 20U << (2 * subdivisions));
    expect_closed_outward(mesh);
    for (const Vec3& vertex : mesh.vertices) {
      ASSERT_NEAR(vertex.norm(), radius_m, 1e-15 * radius_m * 8);
    }
    const double error = 1 - check_mesh(mesh).volume_m3 / (4.0 / 3.0 * pi * std::pow(radius_m, 3));
    EXPECT_GT(error, 0);
    EXPECT_LT(error, subdivisions == 0 ? 0.4 : previous_error / 3);
    previous_error = error;
  }
  EXPECT_LT(previous_error, 3e-3);
}

TEST(Shapes, BoxHasItsFormulasFigures) {
  const Vec3 half(0.01, 0.02, 0.03);
  for (const int cells : {1, 2, 7}) {
    const TriangleMesh mesh = make_box(half, cells);
    ASSERT_EQ(mesh.triangles.size(), 12U * cells * cells);
    expect_closed_outward(mesh);
    const MeshReport report = check_mesh(mesh);
    EXPECT_NEAR(report.volume_m3, 8 * half.prod(), 1e-14 * half.prod() * 8);
    EXPECT_NEAR(report.area_m2, 8 * (half[0] * half[1] + half[1] * half[2] + half[2] * half[0]), 1e-16);
    EXPECT_EQ(report.lower, -half);
    EXPECT_EQ(report.upper, half);
  }
}

TEST(Shapes, CapsuleHasItsFormulasFigures) {
  const double radius_m = 0.02;
  for (const double half_length_m : {0.0, 0.003, 0.2}) {
    const double exact = 4.0 / 3.0 * pi * std::pow(radius_m, 3) + 2 * pi * radius_m * radius_m * half_length_m;
    for (const int segments : {3, 5, 8, 64}) {
      expect_closed_outward(make_capsule(radius_m, half_length_m, segments));
    }
    const TriangleMesh mesh = make_capsule(radius_m, half_length_m, 64);
    const double volume_m3 = check_mesh(mesh).volume_m3;
    EXPECT_LT(volume_m3, exact);
    EXPECT_GT(volume_m3, 0.995 * exact);
    for (const Vec3& vertex : mesh.vertices) {
      const double z = std::clamp(vertex.z(), -half_length_m, half_length_m);
      ASSERT_NEAR((vertex - Vec3(0, 0, z)).norm(), radius_m, 1e-16);
    }
  }
}

TEST(Shapes, RefuseSizesThatMakeNoShape) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  EXPECT_THROW(make_sphere(0, 1), std::invalid_argument);
  EXPECT_THROW(make_sphere(infinity, 1), std::invalid_argument);
  EXPECT_THROW(make_sphere(1, -1), std::invalid_argument);
  EXPECT_THROW(make_box(Vec3(1, 0, 1), 1), std::invalid_argument);
  EXPECT_THROW(make_box(Vec3(1, 1, 1), 0), std::invalid_argument);
  EXPECT_THROW(make_capsule(1, -1, 8), std::invalid_argument);
  EXPECT_THROW(make_capsule(1, 1, 2), std::invalid_argument);
}

}  // namespace
}  // namespace musclebench
