#include "core/mesh/surface_sampler.hpp"

#include <gtest/gtest.h>

namespace musclebench {
namespace {

TEST(SurfaceSampler, SpreadsPointsByArea) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 3}};
  mesh.triangles = {{0, 0, 1}, {0, 1, 2}, {0, 1, 1}, {0, 3, 1}};  // areas 0, 1/2, 0, 3/2
  const SurfaceSampler sampler(mesh);
  RandomNumbers random(1);
  constexpr int count = 40000;
  int of_larger = 0;
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < count; ++i) {
    const SurfaceSample sample = sampler.draw(random);
    ASSERT_TRUE(sample.triangle == 1 || sample.triangle == 3);
    EXPECT_NEAR(sample.normal.norm(), 1, 1e-12);
    if (sample.triangle == 3) {
      ++of_larger;
      sum += sample.point;
      EXPECT_EQ(sample.point.y(), 0);
      EXPECT_LE(sample.point.x() + sample.point.z() / 3, 1 + 1e-12);
    }
  }
  EXPECT_NEAR(of_larger, 0.75 * count, 0.01 * count);
  EXPECT_LT((sum / of_larger - Vec3(1, 0, 3) / 3).norm(), 0.02);
}

}  // namespace
}  // namespace musclebench
