#include "core/measure/edge_stretch.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

TEST(EdgeStretch, AtRestNothingIsStretched) {
  const TriangleMesh sphere = make_sphere(0.1, 3);
  const EdgeStretch stretch = EdgeStretchMeter(sphere).measure(sphere.vertices);
  EXPECT_EQ(stretch.max, 1);
  EXPECT_EQ(stretch.p99, 1);
}

TEST(EdgeStretch, OneNodePulledOutShowsInTheLargestAlone) {
  const TriangleMesh box = make_box({1, 1, 1}, 20);
  EdgeStretchMeter meter(box);
  std::vector<Vec3> positions = box.vertices;
  for (Vec3& position : positions) position *= 1.5;
  EXPECT_NEAR(meter.measure(positions).p99, 1.5, 1e-12);
  positions[0] += Vec3(0, 0, 3);
  const EdgeStretch stretch = meter.measure(positions);
  EXPECT_GT(stretch.max, 20);
  EXPECT_NEAR(stretch.p99, 1.5, 1e-12);
}

TEST(EdgeStretch, EdgesWithoutLengthAreLeftOut) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, 0}, {3, 0, 4}};
  mesh.triangles = {{0, 1, 2}};
  EdgeStretchMeter meter(mesh);
  EXPECT_EQ(meter.mean_length_m(), 5);
  EXPECT_EQ(meter.measure(std::vector<Vec3>{{0, 0, 0}, {9, 0, 0}, {6, 0, 8}}).max, 2);
  EXPECT_TRUE(std::isnan(EdgeStretchMeter(TriangleMesh{}).measure({}).max));
}

}  // namespace
}  // namespace musclebench
