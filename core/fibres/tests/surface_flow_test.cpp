#include "core/fibres/surface_flow.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// An open tube along z from 0 to 1, of irregular triangles: rings between the ends are moved along it.
struct Tube {
  static constexpr int around = 12, rings = 9;
  static constexpr double radius = 0.1;
  TriangleMesh mesh;
  EndNodes ends;

  explicit Tube(double narrowing = 0) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> jitter(-0.3, 0.3);
    for (int ring = 0; ring < rings; ++ring) {
      const bool is_end = ring == 0 || ring == rings - 1;
      for (int i = 0; i < around; ++i) {
        const double z = (ring + (is_end ? 0 : jitter(random))) / (rings - 1);
        const double angle = 2 * std::numbers::pi * i / around;
        const double r = radius * (1 - narrowing * z);
        mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
        if (is_end) (ring == 0 ? ends.origin : ends.insertion).push_back(ring * around + i);
      }
    }
    for (int ring = 0; ring + 1 < rings; ++ring) {
      for (int i = 0; i < around; ++i) {
        const int a = ring * around + i, b = ring * around + (i + 1) % around;
        mesh.triangles.push_back({a, b, a + around});
        mesh.triangles.push_back({b, b + around, a + around});
      }
    }
  }
  [[nodiscard]] double area(const Triangle& triangle) const {
    const Vec3& a = mesh.vertices[triangle[0]];
    return 0.5 * (mesh.vertices[triangle[1]] - a).cross(mesh.vertices[triangle[2]] - a).norm();
  }
};

/// The sheet of a tube of 12 sides is flat along it, so that the flow is straight whatever the triangles. Ends take in
/// at their nodes by area, of which not all have as much here.
TEST(SurfaceFlow, RunsStraightAlongATubeThroughEachSectionOnce) {
  const Tube tube;
  const std::vector<Vec3> flow = surface_flow(tube.mesh, tube.ends);
  ASSERT_EQ(flow.size(), tube.mesh.triangles.size());
  const double around_m = 2 * Tube::around * Tube::radius * std::sin(std::numbers::pi / Tube::around);
  double through = 0;  // all sections, over the length of 1 m
  for (std::size_t t = 0; t < flow.size(); ++t) {
    through += tube.area(tube.mesh.triangles[t]) * flow[t].z();
    EXPECT_NEAR(flow[t].z() * around_m, 1, 0.3);
    EXPECT_GT(flow[t].normalized().z(), 0.95);
  }
  EXPECT_NEAR(through, 1, 1e-9);
}

/// What flows along each triangle's gradients into a node is what enters there: nothing but at the ends.
TEST(SurfaceFlow, LosesNothingOnTheWay) {
  const Tube tube(0.7);
  const std::vector<Vec3> flow = surface_flow(tube.mesh, tube.ends);
  std::vector<double> out(tube.mesh.vertices.size(), 0.0);
  for (std::size_t t = 0; t < flow.size(); ++t) {
    const Triangle& triangle = tube.mesh.triangles[t];
    const auto gradients = barycentric_gradients(tube.mesh, triangle);
    for (int k = 0; k < 3; ++k) out[triangle[k]] += tube.area(triangle) * flow[t].dot(gradients[k]);
  }
  double in = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const bool is_origin = i < Tube::around;
    const bool is_insertion = i >= static_cast<std::size_t>(Tube::around * (Tube::rings - 1));
    if (is_origin) in -= out[i];
    if (!is_origin && !is_insertion) {
      EXPECT_NEAR(out[i], 0, 1e-10);
    }
  }
  EXPECT_NEAR(in, 1, 1e-9);
}

TEST(SurfaceFlow, IsNoneWhereNoPartOfTheSurfaceJoinsBothEnds) {
  Tube tube;
  EXPECT_TRUE(surface_flow(tube.mesh, {tube.ends.origin, {}}).empty());
  EXPECT_TRUE(surface_flow(tube.mesh, {{}, tube.ends.insertion}).empty());
  std::erase_if(tube.mesh.triangles, [](const Triangle& t) { return t[0] / Tube::around == 4; });
  EXPECT_TRUE(surface_flow(tube.mesh, tube.ends).empty());
}

/// A triangle without height, and one nearly without, are as if they were cut out: the rest flows as before.
TEST(SurfaceFlow, PassesByTrianglesWithoutHeight) {
  for (const double height : {0.0, 1e-13, 1e-9}) {
    Tube tube;
    const std::size_t triangles = tube.mesh.triangles.size();
    const std::vector<Vec3> before = surface_flow(tube.mesh, tube.ends);
    const auto middle = static_cast<int>(tube.mesh.vertices.size());
    const int a = 4 * Tube::around;
    const Vec3 along = tube.mesh.vertices[a + 1] - tube.mesh.vertices[a];
    tube.mesh.vertices.emplace_back(tube.mesh.vertices[a] + 0.5 * along + Vec3(0, 0, height));
    tube.mesh.triangles.push_back({a, a + 1, middle});
    const std::vector<Vec3> flow = surface_flow(tube.mesh, tube.ends);
    ASSERT_EQ(flow.size(), triangles + 1);
    EXPECT_EQ(flow.back(), Vec3::Zero());
    for (std::size_t t = 0; t < triangles; ++t) EXPECT_LT((flow[t] - before[t]).norm(), 1e-9);
  }
}

/// A stray part, and one that only one end reaches, have none.
TEST(SurfaceFlow, LeavesOutOtherParts) {
  Tube tube;
  const auto vertices = static_cast<int>(tube.mesh.vertices.size());
  const std::size_t triangles = tube.mesh.triangles.size();
  tube.mesh.vertices.insert(tube.mesh.vertices.end(), {{5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {9, 9, 9}});
  tube.mesh.triangles.push_back({vertices, vertices + 1, vertices + 2});
  tube.ends.origin.push_back(vertices + 1);
  const std::vector<Vec3> flow = surface_flow(tube.mesh, tube.ends);
  ASSERT_EQ(flow.size(), triangles + 1);
  EXPECT_EQ(flow.back(), Vec3::Zero());
  double through = 0;
  for (std::size_t t = 0; t < triangles; ++t) through += tube.area(tube.mesh.triangles[t]) * flow[t].z();
  EXPECT_NEAR(through, 1, 1e-9);
}

}  // namespace
}  // namespace musclebench
