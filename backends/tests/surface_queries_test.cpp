// What contact of faces asks: every backend that answers it is compared with the exact signed distance.
#include <map>
#include <random>

#include "backends/tests/contract.hpp"

namespace musclebench {
namespace {

std::vector<std::string> backends_with_surface_queries() {
  std::vector<std::string> names;
  for (const BackendEntry& entry : backend_registry()) {
    if (entry.make_surface_queries) names.push_back(entry.name);
  }
  return names;
}

class SurfaceQueriesContract : public testing::TestWithParam<std::string> {
 protected:
  /// On the closed bones that a formula gives.
  SurfaceQueriesContract() {
    for (const AnalyticBone& bone : analytic_bones()) bones.push_back({bone.name, repair_mesh(bone.mesh, bone.name)});
    for (Vec3& vertex : bones.back().surface.mesh.vertices) vertex += Vec3(0.137, -0.0513, 0.2291);
    const Parameters parameters(entry.parameters, {}, entry.name);
    backend = entry.make(parameters);
    backend->build(bones, mesh, 1);
    const MakeSurfaceQueries make = entry.make_surface_queries(parameters, bones);
    for (const Bone& bone : bones) queries.push_back(make(bone, 2));
  }

  /// By how much a distance may be wrong.
  [[nodiscard]] double bound_m(std::size_t bone) const {
    const AnswerBound bound = backend->answer_bound(static_cast<int>(bone));
    return std::max(bound.missed_depth_m, bound.false_distance_m) + 1e-12;
  }

  [[nodiscard]] std::vector<Vec3> points_about(std::size_t bone) const {
    Eigen::AlignedBox3d box = bounding_box(bones[bone].surface.mesh.vertices);
    const Vec3 reach = 0.2 * box.diagonal();
    box = {box.min() - reach, box.max() + reach};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<Vec3> points;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 at(share(random), share(random), share(random));
      points.emplace_back(box.min() + at.cwiseProduct(box.sizes()));
    }
    return points;
  }

  const BackendEntry& entry = find_backend(GetParam());
  std::vector<Bone> bones;
  TriangleMesh mesh = muscle();
  std::unique_ptr<CollisionBackend> backend;
  std::vector<std::shared_ptr<const SurfaceQueries>> queries;
};

TEST_P(SurfaceQueriesContract, DistancesAndGradientsAreThoseOfTheSurface) {
  for (std::size_t bone = 0; bone < bones.size(); ++bone) {
    const SignedSurface& exact = bones[bone].signed_distance();
    std::size_t turned = 0;
    for (const Vec3& point : points_about(bone)) {
      const SurfaceAnswer answer = queries[bone]->locate(point, -1);
      const SignedPoint located = exact.locate(point);
      const double distance_m = located.signed_distance_m();
      const bool is_in_box = bounding_box(bones[bone].surface.mesh.vertices).contains(point);
      const double allowed_m = bound_m(bone) + (is_in_box ? 0 : 0.5 * distance_m);
      ASSERT_NEAR(answer.signed_distance_m, distance_m, allowed_m) << bones[bone].name;
      ASSERT_NEAR(answer.gradient.norm(), 1, 1e-9);
      ASSERT_LT((answer.closest_m - (point - distance_m * answer.gradient)).norm(), 2 * allowed_m);
      if (answer.gradient.dot(exact.outward(point, located)) < 0.9) ++turned;
    }
    EXPECT_LE(turned, 100U) << "more than where two closest points compete";
  }
}

TEST_P(SurfaceQueriesContract, AClearanceIsNoLargerThanTheDistance) {
  for (std::size_t bone = 0; bone < bones.size(); ++bone) {
    std::size_t useful = 0;
    for (const Vec3& point : points_about(bone)) {
      const double distance_m = std::abs(bones[bone].signed_distance().locate(point).signed_distance_m());
      const double clearance_m = queries[bone]->clearance(point, -1).distance_m;
      ASSERT_LE(clearance_m, distance_m + bound_m(bone));
      if (clearance_m > 0.1 * distance_m) ++useful;
    }
    EXPECT_GT(useful, 1000U);
  }
}

TEST_P(SurfaceQueriesContract, WhatIsKnownChangesNoBit) {
  const double longest_m = 0.004;
  std::mt19937 random(6);
  std::normal_distribution<double> aside(0, 1);
  for (std::size_t bone = 0; bone < bones.size(); ++bone) {
    for (const Vec3& point : points_about(bone)) {
      const Vec3 step(aside(random), aside(random), aside(random));
      const Vec3 before = point + longest_m / 3 * step;
      const SurfaceAnswer last = queries[bone]->locate(before, -1);
      const SurfaceAnswer fresh = queries[bone]->locate(point, -1);
      for (const SurfaceAnswer& known :
           {queries[bone]->locate(point, last.near), queries[bone]->locate_from(point, before, last)}) {
        ASSERT_EQ(known.signed_distance_m, fresh.signed_distance_m);
        ASSERT_EQ(known.gradient, fresh.gradient);
        ASSERT_EQ(known.closest_m, fresh.closest_m);
      }
    }
  }
}

TEST_P(SurfaceQueriesContract, TheWayOutEndsOnTheSurface) {
  const Vec3 direction = Vec3(0.3, -0.8, 0.5).normalized();
  std::vector<PathCrossing> scratch;
  for (std::size_t bone = 0; bone < bones.size(); ++bone) {
    const SignedSurface& exact = bones[bone].signed_distance();
    const double length_m = bounding_box(bones[bone].surface.mesh.vertices).diagonal().norm();
    int inside = 0;
    for (const Vec3& point : points_about(bone)) {
      // Just under the surface an approximate answer may be on it.
      const double depth_m = -exact.locate(point).signed_distance_m();
      if (depth_m < 2 * bound_m(bone)) continue;
      ++inside;
      const auto way_m = queries[bone]->way_out_m(point, direction, length_m, -1, scratch);
      ASSERT_TRUE(way_m);
      ASSERT_GT(*way_m, 0);
      const double left_m = exact.locate(point + *way_m * direction).signed_distance_m();
      ASSERT_NEAR(left_m, 0, bound_m(bone) + 1e-5 * length_m);
      EXPECT_FALSE(queries[bone]->way_out_m(point, direction, 0.5 * *way_m, -1, scratch));
    }
    EXPECT_GT(inside, 30);
  }
}

/// Where rounding takes a point of the border out of the field's domain depends on where the bone is.
TEST(SurfaceQueriesOfAField, NoBorderOfTheDomainIsASurface) {
  const BackendEntry& entry = find_backend("sdf");
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(-1, 1);
  for (const int cells : {6, 7, 10}) {
    const Parameters parameters(entry.parameters, {{"cells", std::int64_t{cells}}}, "test");
    for (int shift = 0; shift < 20; ++shift) {
      TriangleMesh mesh = make_sphere(sphere_radius_m, 2);
      const Vec3 moved(anywhere(random), anywhere(random), anywhere(random));
      for (Vec3& vertex : mesh.vertices) vertex += moved;
      const std::vector<Bone> bones = {{"ball", repair_mesh(mesh, "ball")}};
      const auto queries = entry.make_surface_queries(parameters, bones)(bones[0], 1);
      for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
          // Beside the ball, where it is far from its box.
          Vec3 beside = Vec3::Constant(0.9 * sphere_radius_m);
          beside[axis] = side * 1.1 * sphere_radius_m;
          EXPECT_GT(queries->locate(moved + beside, -1).signed_distance_m, 0.4 * sphere_radius_m);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, SurfaceQueriesContract, testing::ValuesIn(backends_with_surface_queries()),
                         [](const auto& each) { return each.param; });

}  // namespace
}  // namespace musclebench
