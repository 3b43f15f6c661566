#include "core/measure/ring_meter.hpp"

#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// Of a box whose faces are large: their nodes are far from the ring's plane.
struct Bar {
  TriangleMesh mesh = make_box({0.003, 0.004, 0.05}, 1);
  std::vector<Retinaculum> rings;
  std::vector<RigidMotion> poses{RigidMotion{}};

  explicit Bar(double radius_m) {
    rings.push_back({.name = "ring", .axis = Vec3::UnitZ(), .radius_m = radius_m, .half_width_m = 0.06});
    rings[0].nodes.resize(mesh.vertices.size());
    std::iota(rings[0].nodes.begin(), rings[0].nodes.end(), 0);
  }
  [[nodiscard]] RingEscape measure(const Vec3& moved_m = Vec3::Zero()) const {
    std::vector<Vec3> positions = mesh.vertices;
    for (Vec3& at : positions) at = poses[0].apply(at + moved_m);
    return RingMeter(rings, mesh).measure(positions, poses);
  }
};

TEST(RingMeter, ABarInItsRingIsInIt) {
  EXPECT_EQ(Bar(0.0051).measure().ring, -1);
  EXPECT_EQ(Bar(0.0051).measure().outside_m, 0);
}

TEST(RingMeter, TellsHowFarTheFacesReachOut) {
  Bar bar(0.004);
  EXPECT_NEAR(bar.measure().outside_m, 0.001, 1e-12);  // its corners are 5 mm from the axis
  EXPECT_NEAR(bar.measure().share, 0.25, 1e-9);
  bar.poses[0] = RigidMotion::about_axis(Vec3(3, 1, 2).normalized(), Vec3(0.1, 0.2, 0.3), 0.7);
  EXPECT_NEAR(bar.measure(Vec3(0.003, 0, 0)).outside_m, std::hypot(0.006, 0.004) - 0.004, 1e-12);
}

TEST(RingMeter, ATendonThatSlidOutOfItsRingIsOut) {
  const Bar bar(0.0051);
  EXPECT_NEAR(bar.measure(Vec3(0, 0, 0.08)).outside_m, std::hypot(0.003, 0.004, 0.03), 1e-12);
  EXPECT_TRUE(bar.measure(Vec3(0, 0, 0.08)).has_left);
  EXPECT_FALSE(bar.measure(Vec3(0.01, 0, 0)).has_left);
}

TEST(RingMeter, TheWorstOfSeveralIsTold) {
  Bar bar(0.0051);
  bar.rings.push_back(bar.rings[0]);
  bar.rings[1].radius_m = 0.004;
  EXPECT_EQ(bar.measure().ring, 1);
}

}  // namespace
}  // namespace musclebench
