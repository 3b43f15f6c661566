#include "core/mesh/split_mesh.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_volume.hpp"
#include "core/mesh_repair/check_mesh.hpp"

namespace musclebench {
namespace {

constexpr double radius_m = 0.03;

TriangleMesh uneven_ball(int subdivisions) {
  TriangleMesh ball = make_sphere(radius_m, subdivisions);
  // Points of the sphere, though not evenly spaced.
  for (Vec3& vertex : ball.vertices) vertex = radius_m * (vertex + Vec3(0.006, 0.002, 0.004)).normalized();
  return ball;
}

double largest_depth_m(const TriangleMesh& mesh) {
  double largest_m = 0;
  for (const Vec3& vertex : mesh.vertices) largest_m = std::max(largest_m, std::abs(vertex.norm() - radius_m));
  return largest_m;
}

TEST(SplitMesh, FlatKeepsTheSurfaceAndItsVertices) {
  const TriangleMesh coarse = make_capsule(0.02, 0.04, 12);
  for (const int times : {0, 1, 3}) {
    const TriangleMesh fine = split_flat(coarse, times);
    ASSERT_EQ(fine.triangles.size(), coarse.triangles.size() << (2 * times));
    EXPECT_TRUE(std::equal(coarse.vertices.begin(), coarse.vertices.end(), fine.vertices.begin()));
    EXPECT_EQ(describe(check_mesh(fine)).front(), "no defects");
    const double volume_m3 = surface_volume_m3(coarse.vertices, coarse.triangles);
    EXPECT_NEAR(surface_volume_m3(fine.vertices, fine.triangles), volume_m3, 1e-13 * volume_m3);
  }
}

TEST(SplitMesh, SideOfSeveralVerticesAtOnePositionStaysClosed) {
  const TriangleMesh coarse = make_box(Vec3(0.1, 0.23, 0.37), 1);
  TriangleMesh soup;  // as an STL file has it
  for (const Triangle& triangle : coarse.triangles) {
    const auto first = static_cast<int>(soup.vertices.size());
    for (const int corner : triangle) soup.vertices.push_back(coarse.vertices[corner]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  for (const TriangleMesh& fine : {split_flat(soup, 2), split_curved(soup, 2)}) {
    const MeshReport report = check_mesh(fine);
    EXPECT_EQ(report.vertices - report.duplicate_vertices, 12 * 16 / 2 + 2);
    EXPECT_EQ(report.boundary_edges, 0);
  }
}

TEST(SplitMesh, TriangleOfTwoCornersHasNoMiddleToItself) {
  const TriangleMesh mesh{{Vec3::Zero(), Vec3::UnitX()}, {{0, 0, 1}}};
  const TriangleMesh fine = split_flat(mesh, 1);
  EXPECT_EQ(fine.vertices.size(), 3U);
  for (const Vec3& vertex : split_curved(mesh, 2).vertices) EXPECT_TRUE(vertex.allFinite());
}

TEST(SplitMesh, CurvedErrsByTheFourthPowerOfTheEdgesOfASphere) {
  double before_m = 0;
  for (const int subdivisions : {2, 3, 4}) {
    const TriangleMesh coarse = uneven_ball(subdivisions);
    const TriangleMesh fine = split_curved(coarse, 3);
    EXPECT_TRUE(std::equal(coarse.vertices.begin(), coarse.vertices.end(), fine.vertices.begin()));
    EXPECT_EQ(describe(check_mesh(fine)).front(), "no defects");
    const double depth_m = largest_depth_m(fine);
    EXPECT_LT(depth_m, 0.04 * largest_depth_m(split_flat(coarse, 1)));
    if (before_m > 0) {
      EXPECT_NEAR(before_m / depth_m, 16, 3);
    }
    before_m = depth_m;
  }
}

TEST(SplitMesh, CurvedKeepsCornersAndFlatFacesOfABox) {
  const Vec3 half_m(0.01, 0.02, 0.03);
  for (const int cells : {1, 3}) {
    const MeshReport report = check_mesh(split_curved(make_box(half_m, cells), 2));
    EXPECT_NEAR(report.volume_m3, 8 * half_m.prod(), 1e-12 * 8 * half_m.prod());
    EXPECT_NEAR(report.area_m2, 8 * (half_m[0] * half_m[1] + half_m[1] * half_m[2] + half_m[2] * half_m[0]), 1e-14);
  }
}

}  // namespace
}  // namespace musclebench
