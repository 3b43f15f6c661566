#include "core/bvh/nearby_triangles.hpp"

#include <random>

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
  for (const double margin_m : {0.0, 0.002, 0.03}) {
    const NearbyTriangles part(mesh, box, margin_m);
    int found = 0;
    for (int i = 0; i < 2000; ++i) {
      const double x = share(random);
      const double y = share(random);
      const Vec3 point = box.min() + Vec3(x, y, share(random)).cwiseProduct(box.sizes());
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
  const auto answer = NearbyTriangles(mesh, {at, at}, 0.5).closest_point(at, 0.5);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->distance_m, 0.5);
  EXPECT_EQ(answer->triangle, TriangleBvh(mesh).closest_point(at)->triangle);
  EXPECT_FALSE(NearbyTriangles(mesh, {at, at}, 0.4).closest_point(at, 0.4));
  EXPECT_FALSE(NearbyTriangles(mesh, {}, 0.4).closest_point(at, 0.4));
}

}  // namespace
}  // namespace musclebench
