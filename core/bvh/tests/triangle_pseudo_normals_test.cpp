#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/bvh/triangle_bvh.hpp"
#include "core/distance/pseudo_normals.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

TriangleMesh tetrahedron(std::mt19937& generator) {
  std::uniform_real_distribution<double> coordinate(-1, 1);
  TriangleMesh mesh;
  for (int i = 0; i < 4; ++i) {
    const double x = coordinate(generator);
    const double y = coordinate(generator);
    mesh.vertices.emplace_back(x, y, coordinate(generator));
  }
  const auto& v = mesh.vertices;
  if ((v[1] - v[0]).cross(v[2] - v[0]).dot(v[3] - v[0]) > 0) {
    std::swap(mesh.vertices[1], mesh.vertices[2]);
  }
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  return mesh;
}

bool inside_all_planes(const TriangleMesh& mesh, const Vec3& point) {
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[static_cast<std::size_t>(t[0])];
    const Vec3& b = mesh.vertices[static_cast<std::size_t>(t[1])];
    const Vec3& c = mesh.vertices[static_cast<std::size_t>(t[2])];
    if ((b - a).cross(c - a).dot(point - a) >= 0) {
      return false;
    }
  }
  return true;
}

TEST(PseudoNormals, SignIsRightAtSharpCornersOfRandomTetrahedra) {
  // Obtuse corner angles folded to acute ones give thousands of wrong signs here.
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
  int at_corners = 0;
  int wrong = 0;
  for (int shape = 0; shape < 500; ++shape) {
    const TriangleMesh mesh = tetrahedron(generator);
    const TriangleBvh tree(mesh);
    const PseudoNormals normals(mesh);
    for (int i = 0; i < 100; ++i) {
      const double x = coordinate(generator);
      const double y = coordinate(generator);
      const Vec3 point(x, y, coordinate(generator));
      const ClosestPoint closest = *tree.closest_point(point);
      at_corners += closest.feature >= Feature::corner_0 ? 1 : 0;
      const bool inside = normals.is_inside(point, closest.point, closest.triangle, closest.feature);
      wrong += inside != inside_all_planes(mesh, point) ? 1 : 0;
    }
  }
  EXPECT_GT(at_corners, 10000);
  EXPECT_EQ(wrong, 0);
}

TEST(PseudoNormals, OfABoxPointAlongTheDiagonals) {
  const TriangleMesh box = make_box({1, 1, 1}, 1);
  const PseudoNormals normals(box);
  for (std::size_t t = 0; t < box.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto feature = static_cast<Feature>(static_cast<std::size_t>(Feature::corner_0) + i);
      const Vec3& vertex = box.vertices[static_cast<std::size_t>(box.triangles[t][i])];
      // Three right angles, however the faces are cut into triangles.
      EXPECT_NEAR((normals.at(static_cast<int>(t), feature) - std::numbers::pi / 2 * vertex).norm(), 0, 1e-12);
    }
  }
}

TEST(PseudoNormals, OfAZeroThicknessFinAreFiniteAndTheWindingNumberKnowsBetter) {
  // A tetrahedron with a doubled triangle standing on one of its edges: the faces of the fin cancel.
  std::mt19937 generator(5);
  TriangleMesh mesh = tetrahedron(generator);
  const Vec3 centre = (mesh.vertices[0] + mesh.vertices[1] + mesh.vertices[2] + mesh.vertices[3]) / 4;
  const Vec3 tip = centre + 4 * (0.5 * (mesh.vertices[0] + mesh.vertices[1]) - centre);
  mesh.vertices.push_back(tip);
  mesh.triangles.push_back({0, 1, 4});
  mesh.triangles.push_back({1, 0, 4});
  const TriangleBvh tree(mesh);
  const PseudoNormals normals(mesh);
  const Vec3 beyond_tip = tip + 0.1 * (tip - centre);
  const ClosestPoint closest = *tree.closest_point(beyond_tip);
  EXPECT_NEAR((closest.point - tip).norm(), 0, 1e-12);
  EXPECT_TRUE(normals.at(closest.triangle, closest.feature).allFinite());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int feature = 0; feature < 7; ++feature) {
      EXPECT_TRUE(normals.at(static_cast<int>(t), static_cast<Feature>(feature)).allFinite());
    }
  }
  EXPECT_LT(tree.winding_number(beyond_tip), 0.5);
  EXPECT_LT(tree.winding_number(tip + Vec3(1e-3, 1e-3, 1e-3)), 0.5);
  EXPECT_GT(tree.winding_number(centre), 0.5);
}

}  // namespace
}  // namespace musclebench
