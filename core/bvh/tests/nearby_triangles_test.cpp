#include "core/bvh/nearby_triangles.hpp"

#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

TEST(NearbyTriangles, GiveTheAnswerOfTheWholeTreeToTheBit) {
  const TriangleMesh mesh = make_sphere(0.1, 4);
  const TriangleBvh whole(mesh);
  const Eigen::AlignedBox3d box(Vec3(0.05, -0.02, 0.03), Vec3(0.11, 0.05, 0.08));
  std::mt19937 random(2);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Vec3> points;
  for (int i = 0; i < 2000; ++i) {
    const double x = share(random);
    const double y = share(random);
    points.emplace_back(box.min() + Vec3(x, y, share(random)).cwiseProduct(box.sizes()));
  }
  for (const double margin_m : {0.0, 0.002, 0.03}) {
    const NearbyTriangles part(mesh, points, margin_m);
    int found = 0;
    for (const Vec3& point : points) {
      const auto expected = whole.closest_point(point, margin_m);
      const auto answer = part.closest_point(point, margin_m);
      ASSERT_EQ(answer.has_value(), expected.has_value());
      if (!answer) continue;
      ++found;
      EXPECT_EQ(answer->point, expected->point);
      EXPECT_EQ(answer->distance_m, expected->distance_m);
      EXPECT_EQ(answer->triangle, expected->triangle);
    }
    EXPECT_EQ(found > 50, margin_m > 0);
  }
}

TEST(NearbyTriangles, OnTheSurfaceAndAtTheMarginItselfArePartOfIt) {
  const TriangleMesh mesh = make_box(Vec3(1, 1, 1), 2);
  const Vec3 at(1.5, 0.25, 0.25);
  const auto answer = NearbyTriangles(mesh, std::span(&at, 1), 0.5).closest_point(at, 0.5);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->distance_m, 0.5);
  EXPECT_EQ(answer->triangle, TriangleBvh(mesh).closest_point(at)->triangle);
  EXPECT_FALSE(NearbyTriangles(mesh, std::span(&at, 1), 0.4).closest_point(at, 0.4));
  EXPECT_FALSE(NearbyTriangles(mesh, {}, 0.4).closest_point(at, 0.4));
}

/// Few points far apart: what lies between them is left out, and changes nothing.
TEST(NearbyTriangles, MayLieInSeveralPlaces) {
  const TriangleMesh mesh = make_sphere(0.1, 5);
  const TriangleBvh whole(mesh);
  const std::vector<Vec3> points = {Vec3(0.1, 0, 0.001), Vec3(-0.07, 0.07, 0.01), Vec3(0, 0.001, -0.101)};
  const NearbyTriangles part(mesh, points, 0.004);
  EXPECT_LT(part.triangle_count(), mesh.triangles.size() / 20);
  for (const Vec3& point : points) {
    const auto expected = whole.closest_point(point, 0.004);
    const auto answer = part.closest_point(point, 0.004);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->point, expected->point);
    EXPECT_EQ(answer->triangle, expected->triangle);
  }
}

}  // namespace
}  // namespace musclebench
