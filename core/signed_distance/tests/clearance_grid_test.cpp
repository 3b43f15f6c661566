#include "core/signed_distance/clearance_grid.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random_numbers.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

struct Gridded {
  explicit Gridded(const TriangleMesh& mesh, int threads = 1)
      : box(bounding_box(mesh.vertices)),
        surface(repair_mesh(mesh, "mesh")),
        grid(surface, box, mean_triangle_size_m(mesh), threads) {}

  Eigen::AlignedBox3d box;
  SignedSurface surface;
  ClearanceGrid grid;
};

std::vector<Vec3> points_about(const Eigen::AlignedBox3d& box, std::size_t count) {
  RandomNumbers random(11);
  std::vector<Vec3> points;
  while (points.size() < count) {
    const Vec3 share(random.share(), random.share(), random.share());
    points.emplace_back(box.min() + (2 * share - Vec3::Constant(0.5)).cwiseProduct(box.sizes()));
  }
  return points;
}

/// A shell, whose cavity is outside.
TriangleMesh hollow_sphere() {
  TriangleMesh mesh = make_sphere(1, 5);
  const TriangleMesh cavity = make_sphere(0.7, 5);
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), cavity.vertices.begin(), cavity.vertices.end());
  for (const Triangle& t : cavity.triangles) {
    mesh.triangles.push_back({t[0] + first, t[2] + first, t[1] + first});
  }
  return mesh;
}

void expect_true_and_useful(const TriangleMesh& mesh, std::size_t count) {
  const Gridded gridded(mesh);
  const double coarsest_m = std::max(3.001 * mean_triangle_size_m(mesh), 1.001 / 96 * gridded.box.sizes().maxCoeff());
  for (const Vec3& point : points_about(gridded.box, count)) {
    const double distance_m = gridded.surface.locate(point).signed_distance_m();
    const double clearance_m = gridded.grid.clearance_m(point);
    ASSERT_LE(clearance_m, std::max(distance_m, 0.0)) << point.transpose();
    if (gridded.box.contains(point)) {
      // The distance to a cube's centre is lost twice; far away a fraction of the distance, too.
      ASSERT_GE(clearance_m, 0.7 * distance_m - 1.74 * coarsest_m) << point.transpose();
    }
  }
}

TEST(ClearanceGrid, IsBelowTheDistanceAndNotFar) {
  expect_true_and_useful(make_sphere(1, 5), 20000);
  expect_true_and_useful(make_box({1, 0.5, 0.25}, 40), 20000);
  expect_true_and_useful(make_capsule(0.01, 0.02, 100), 20000);
  expect_true_and_useful(hollow_sphere(), 20000);
}

TEST(ClearanceGrid, CoversTheCavityOfAShell) {
  const Gridded gridded(hollow_sphere());
  EXPECT_GT(gridded.grid.clearance_m(Vec3::Zero()), 0.4);
  EXPECT_LE(gridded.grid.clearance_m(Vec3::Zero()), 0.7);
  EXPECT_EQ(gridded.grid.clearance_m({0.85, 0, 0}), 0);
}

TEST(ClearanceGrid, HoldsFarAway) {
  const Gridded gridded(make_sphere(1, 5));
  for (const double far_m : {2.0, 1e3, 1e9, 1e15, 1e99}) {
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0.6, -0.8, 0)}) {
      EXPECT_LE(gridded.grid.clearance_m(far_m * direction), far_m - 0.99);
    }
  }
}

TEST(ClearanceGrid, IsTheSameForAnyNumberOfThreads) {
  const TriangleMesh mesh = make_capsule(0.01, 0.05, 60);
  const Gridded alone(mesh);
  for (const int threads : {2, 5}) {
    const Gridded shared(mesh, threads);
    for (const Vec3& point : points_about(alone.box, 5000)) {
      ASSERT_EQ(shared.grid.clearance_m(point), alone.grid.clearance_m(point));
    }
  }
}

TEST(ClearanceGrid, IsZeroWithoutASurface) {
  EXPECT_EQ(ClearanceGrid().clearance_m({1, 2, 3}), 0);
  EXPECT_EQ(ClearanceGrid().bytes(), 0U);
}

TEST(ClearanceGrid, IsSmallForACoarseMesh) {
  EXPECT_LT(Gridded(make_box({1, 1, 1}, 1)).grid.bytes(), 100U);
  EXPECT_LT(Gridded(make_sphere(1, 6)).grid.bytes(), 2'000'000U);
}

}  // namespace
}  // namespace musclebench
