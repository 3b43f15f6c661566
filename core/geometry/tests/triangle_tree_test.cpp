#include "core/geometry/triangle_tree.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/geometry/shapes.hpp"

namespace musclebench {
namespace {

const Vec3& corner(const TriangleMesh& mesh, const Triangle& triangle, std::size_t i) {
  return mesh.vertices[static_cast<std::size_t>(triangle[i])];
}

ClosestPoint brute_force(const TriangleMesh& mesh, const Vec3& point) {
  ClosestPoint best;
  double squared = 1e300;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& triangle = mesh.triangles[t];
    const ClosestOnTriangle found =
        closest_on_triangle(point, corner(mesh, triangle, 0), corner(mesh, triangle, 1), corner(mesh, triangle, 2));
    if (found.squared_distance_m2 < squared) {
      squared = found.squared_distance_m2;
      best = {found.point, std::sqrt(squared), static_cast<int>(t), found.feature};
    }
  }
  return best;
}

double exact_winding(const TriangleMesh& mesh, const Vec3& point) {
  double angle = 0;
  for (const Triangle& t : mesh.triangles) {
    angle += solid_angle(point, corner(mesh, t, 0), corner(mesh, t, 1), corner(mesh, t, 2));
  }
  return angle / (4 * std::numbers::pi);
}

std::vector<Vec3> random_points(double reach, int count) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> coordinate(-reach, reach);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = coordinate(generator);
    const double y = coordinate(generator);
    points.emplace_back(x, y, coordinate(generator));
  }
  return points;
}

/// Random triangles, some of them degenerate: nothing that helps the tree.
TriangleMesh soup(int triangles) {
  TriangleMesh mesh;
  mesh.vertices = random_points(1, 3 * triangles);
  for (int t = 0; t < triangles; ++t) {
    mesh.triangles.push_back({3 * t, 3 * t + 1, t % 10 == 0 ? 3 * t : 3 * t + 2});
  }
  return mesh;
}

class TriangleTreeShapes : public testing::TestWithParam<TriangleMesh> {};

TEST_P(TriangleTreeShapes, ClosestPointIsThatOfBruteForce) {
  const TriangleMesh& mesh = GetParam();
  const TriangleTree tree(mesh);
  int start = 0;
  for (const Vec3& point : random_points(1.5, 300)) {
    const ClosestPoint expected = brute_force(mesh, point);
    const std::optional<ClosestPoint> found = tree.closest_point(point);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->triangle, expected.triangle);
    EXPECT_EQ(found->distance_m, expected.distance_m);
    EXPECT_EQ(found->point, expected.point);
    EXPECT_EQ(found->feature, expected.feature);

    start = (start + 37) % static_cast<int>(mesh.triangles.size());
    const ClosestPoint from = tree.closest_point_from(point, start);
    EXPECT_EQ(from.triangle, expected.triangle);
    EXPECT_EQ(from.distance_m, expected.distance_m);
  }
}

TEST_P(TriangleTreeShapes, TheCapOnlyDecidesWhetherThereIsAnAnswer) {
  const TriangleMesh& mesh = GetParam();
  const TriangleTree tree(mesh);
  for (const Vec3& point : random_points(1.5, 100)) {
    const double distance = brute_force(mesh, point).distance_m;
    EXPECT_FALSE(tree.closest_point(point, 0.999 * distance));
    const std::optional<ClosestPoint> found = tree.closest_point(point, 1.001 * distance);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->distance_m, distance);
  }
}

TEST_P(TriangleTreeShapes, WindingNumberIsTheSumOfSolidAngles) {
  const TriangleMesh& mesh = GetParam();
  const TriangleTree tree(mesh);
  for (const Vec3& point : random_points(1.5, 200)) {
    const double expected = exact_winding(mesh, point);
    const double found = tree.winding_number(point);
    EXPECT_NEAR(found, expected, 0.2);
    if (std::abs(expected - 0.5) > 1e-9) {
      EXPECT_EQ(found > 0.5, expected > 0.5) << point.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, TriangleTreeShapes,
                         testing::Values(make_sphere(1, 4), make_box({0.5, 1, 0.25}, 1), make_box({0.5, 1, 0.25}, 9),
                                         make_capsule(0.3, 0.9, 24), soup(500), soup(3)));

TEST(TriangleTree, IsDeepEnoughForManyTrianglesAtOnePlace) {
  TriangleMesh mesh = make_sphere(1, 0);
  const std::vector<Triangle> once = mesh.triangles;
  for (int copy = 0; copy < 500; ++copy) {
    mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
  }
  const TriangleTree tree(mesh);
  const Vec3 point(0.3, 0.2, 1.4);
  EXPECT_EQ(tree.closest_point(point)->triangle, brute_force(mesh, point).triangle);
}

TEST(TriangleTree, WindingNumberCountsNestedSurfaces) {
  TriangleMesh mesh = make_sphere(1, 3);
  const TriangleMesh inner = make_sphere(0.5, 3);
  const auto offset = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), inner.vertices.begin(), inner.vertices.end());
  for (const Triangle& t : inner.triangles) {
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  const TriangleTree tree(mesh);
  EXPECT_NEAR(tree.winding_number({0.1, 0, 0.2}), 2, 0.1);
  EXPECT_NEAR(tree.winding_number({0.7, 0, 0.2}), 1, 0.1);
  EXPECT_NEAR(tree.winding_number({1.7, 0, 0.2}), 0, 0.1);
}

TEST(TriangleTree, OfNoTrianglesHasNoClosestPoint) {
  const TriangleTree tree((TriangleMesh()));
  EXPECT_FALSE(tree.closest_point(Vec3::Zero()));
  EXPECT_EQ(tree.winding_number(Vec3::Zero()), 0);
}

}  // namespace
}  // namespace musclebench
