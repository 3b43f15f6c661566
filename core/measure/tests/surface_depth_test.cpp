#include "core/measure/surface_depth.hpp"

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/referee/tests/naive_truth.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

/// One muscle, judged against bones by a Referee and a meter that see every call.
class Scene {
 public:
  Scene(const std::vector<TriangleMesh>& bones, const TriangleMesh& muscle, std::vector<int> carriers = {})
      : m_muscle(muscle), m_carriers(std::move(carriers)) {
    for (const TriangleMesh& mesh : bones) m_bones.push_back(bone_of(mesh));
    m_carriers.resize(muscle.vertices.size(), -1);
    for (const int node : all_nodes(m_carriers.size())) {
      if (m_carriers[static_cast<std::size_t>(node)] < 0) m_free.push_back(node);
    }
    m_referee.emplace(m_bones, static_cast<int>(muscle.vertices.size()));
    m_meter.emplace(m_muscle.triangles, m_carriers, static_cast<int>(bones.size()));
  }

  DeepestSurfacePoint measure(const std::vector<Vec3>& positions, const std::vector<RigidMotion>& poses,
                              long budget = std::numeric_limits<long>::max()) {
    m_referee->judge(poses, positions, m_free, m_truth);
    return m_meter->measure(*m_referee, poses, positions, m_truth, budget);
  }
  DeepestSurfacePoint measure(long budget = std::numeric_limits<long>::max()) {
    return measure(m_muscle.vertices, std::vector<RigidMotion>(m_bones.size()), budget);
  }
  DepthsAroundNodes measure_around_nodes(const std::vector<Vec3>& positions, const std::vector<RigidMotion>& poses,
                                         long budget = std::numeric_limits<long>::max()) {
    m_referee->judge(poses, positions, m_free, m_truth);
    return m_meter->measure_around_nodes(*m_referee, poses, positions, m_truth, budget);
  }
  DepthsAroundNodes measure_around_nodes(long budget = std::numeric_limits<long>::max()) {
    return measure_around_nodes(m_muscle.vertices, std::vector<RigidMotion>(m_bones.size()), budget);
  }
  [[nodiscard]] bool a_node_is_inside() const { return !m_truth.empty(); }
  [[nodiscard]] long work() const { return m_meter->last_work(); }

 private:
  TriangleMesh m_muscle;
  std::vector<int> m_carriers;
  std::vector<Bone> m_bones;
  std::vector<int> m_free;
  std::optional<Referee> m_referee;
  std::optional<SurfaceDepthMeter> m_meter;
  std::vector<Contact> m_truth;
};

double tolerance(const TriangleMesh& bone, double depth_m) {
  return SurfaceDepthMeter::relative_tolerance * depth_m +
         SurfaceDepthMeter::absolute_tolerance * naive::diagonal(bone) * (1 + 1e-9);
}

void expect_depth(const DeepestSurfacePoint& found, double depth_m, const TriangleMesh& bone) {
  EXPECT_LE(found.depth_m, depth_m + 1e-12 * naive::diagonal(bone));
  EXPECT_GE(found.depth_m, depth_m - tolerance(bone, depth_m));
  EXPECT_GE(found.bound_m, depth_m - 1e-12 * naive::diagonal(bone));
  EXPECT_LE(found.bound_m, found.depth_m + tolerance(bone, depth_m)) << "nothing is left open";
}

/// A face across the ridge of make_roof at height z, its corners far outside.
TriangleMesh face_at(double z) {
  TriangleMesh mesh;
  mesh.vertices = {{-0.7, -0.5, z}, {0.8, -0.4, z}, {0.1, 0.9, z}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

TEST(SurfaceDepth, RidgeThroughAFaceWhoseCornersAreOutside) {
  const TriangleMesh roof = make_roof(0.3, 0.4, 2);
  for (const double sunk : {0.1, 0.01}) {
    Scene scene({roof}, face_at(-sunk));
    const DeepestSurfacePoint found = scene.measure();
    EXPECT_FALSE(scene.a_node_is_inside());
    expect_depth(found, sunk * 0.6, roof);  // sine of the angle between ridge and flank: 0.3 / 0.5
    EXPECT_EQ(found.triangle, 0);
    EXPECT_NEAR(found.point_m.x(), 0, 2 * tolerance(roof, sunk));
    EXPECT_NEAR(found.point_m.z(), -sunk, 1e-15);
  }
}

TEST(SurfaceDepth, NothingInsideIsExactlyZero) {
  const TriangleMesh roof = make_roof(0.3, 0.4, 2);
  for (const double above : {1.0, 0.01, 1e-5}) {
    Scene scene({roof}, face_at(above));
    EXPECT_EQ(scene.measure().depth_m, 0);
    EXPECT_EQ(scene.measure().bone, -1);
  }
}

TEST(SurfaceDepth, FarTrianglesCostNoWork) {
  Scene scene({make_box({0.1, 0.1, 0.1}, 4)}, moved(make_sphere(0.1, 3), Vec3(1, 0, 0)));
  EXPECT_EQ(scene.measure().depth_m, 0);
  EXPECT_EQ(scene.work(), 0);
}

TEST(SurfaceDepth, SphereInSphere) {
  const TriangleMesh bone = make_sphere(1, 5);
  Scene scene({bone}, moved(make_sphere(0.3, 4), Vec3(0.9, 0, 0)));
  EXPECT_NEAR(scene.measure().depth_m, 0.4, 2e-3);
}

TEST(SurfaceDepth, WholeMuscleInsideABox) {
  // The middle of a face of the inner box is the deepest: 0.5 to the side, but 0.6 - 0.2 = 0.4 up.
  const TriangleMesh bone = make_box({0.6, 0.6, 0.6}, 3);
  Scene scene({bone}, make_box({0.1, 0.1, 0.2}, 1));
  expect_depth(scene.measure(), 0.5, bone);  // at the side's middle height
}

/// Largest depth over a grid of points, none farther than `spacing_m` from any point of the surface.
double sampled_depth(const TriangleMesh& bone, const std::vector<Vec3>& positions,
                     const std::vector<Triangle>& triangles, double spacing_m) {
  double deepest = 0;
  for (const Triangle& t : triangles) {
    const Vec3& a = positions[static_cast<std::size_t>(t[0])];
    const Vec3 ab = positions[static_cast<std::size_t>(t[1])] - a;
    const Vec3 ac = positions[static_cast<std::size_t>(t[2])] - a;
    const int n = 1 + static_cast<int>(std::max({ab.norm(), ac.norm(), (ab - ac).norm()}) / spacing_m);
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        const Vec3 point = a + ab * i / n + ac * j / n;
        if (naive::winding_number(bone, point) > 0.5) deepest = std::max(deepest, naive::distance(bone, point));
      }
    }
  }
  return deepest;
}

TEST(SurfaceDepth, SamplingFindsTheSame) {
  const TriangleMesh bone = make_capsule(0.1, 0.3, 10);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  for (int i = 0; i < 4; ++i) {
    TriangleMesh muscle = moved(make_box({0.2, 0.02, 0.2}, 2), Vec3(shift(random), 0.1, shift(random)));
    for (Vec3& vertex : muscle.vertices) vertex.y() += 0.05 * shift(random) - 0.2 * vertex.x() * vertex.x();
    const double found = Scene({bone}, muscle).measure().depth_m;
    const double spacing = 0.01;
    const double sampled = sampled_depth(bone, muscle.vertices, muscle.triangles, spacing);
    EXPECT_GT(sampled, 0.01);
    EXPECT_GE(found, sampled - tolerance(bone, sampled));
    EXPECT_LE(found, sampled + spacing);
  }
}

TEST(SurfaceDepth, AtLeastTheDeepestNode) {
  const TriangleMesh bone = make_box({1, 1, 1}, 1);
  TriangleMesh muscle;
  muscle.vertices = {{0, 0, 0.4}, {0.1, 0, 3}, {0, 0.1, 3}};
  muscle.triangles = {{0, 1, 2}};
  expect_depth(Scene({bone}, muscle).measure(), 0.6, bone);
  // Carried nodes around it: the triangle does not count, the free node does.
  EXPECT_DOUBLE_EQ(Scene({bone}, muscle, {-1, 0, 0}).measure().depth_m, 0.6);
}

TEST(SurfaceDepth, WhatABoneCarriesDoesNotCountAgainstIt) {
  const TriangleMesh bone = make_box({1, 1, 1}, 1);
  TriangleMesh muscle;
  muscle.vertices = {{0, 0, 0.4}, {0.5, 0, 3}, {0, 0.5, 3}};
  muscle.triangles = {{0, 1, 2}};
  EXPECT_EQ(Scene({bone}, muscle, {0, -1, -1}).measure().depth_m, 0);
  EXPECT_EQ(Scene({bone}, muscle, {0, 0, 0}).measure().depth_m, 0);
  // Carried by another bone it counts, unless nothing of it is free.
  const TriangleMesh far = moved(bone, Vec3(10, 0, 0));
  expect_depth(Scene({bone, far}, muscle, {1, -1, -1}).measure(), 0.6, bone);
  EXPECT_EQ(Scene({bone, far}, muscle, {1, 1, 1}).measure().depth_m, 0);
}

TEST(SurfaceDepth, TheDeepestOfSeveralBones) {
  const TriangleMesh roof = make_roof(0.3, 0.4, 2);
  Scene scene({moved(roof, Vec3(0, 0, -0.02)), roof, moved(roof, Vec3(0, 0, -5))}, face_at(-0.1));
  const DeepestSurfacePoint found = scene.measure();
  expect_depth(found, 0.06, roof);
  EXPECT_EQ(found.bone, 1);
}

TEST(SurfaceDepth, MovesWithBoneAndMuscle) {
  const TriangleMesh roof = make_roof(0.3, 0.4, 2);
  const TriangleMesh face = face_at(-0.1);
  Scene scene({roof}, face);
  const DeepestSurfacePoint found = scene.measure(moved(face, some_motion()).vertices, {some_motion()});
  expect_depth(found, 0.06, roof);
  EXPECT_NEAR(some_motion().apply_inverse(found.point_m).z(), -0.1, 1e-12);
}

TEST(SurfaceDepth, ScalesToTheBit) {
  const TriangleMesh bone = make_capsule(0.1, 0.3, 10);
  const TriangleMesh muscle = moved(make_sphere(0.2, 2), Vec3(0.25, 0.03, 0.1));
  const double depth = Scene({bone}, muscle).measure().depth_m;
  EXPECT_GT(depth, 0.01);
  for (const double factor : {0x1p10, 0x1p-10}) {
    EXPECT_EQ(Scene({scaled(bone, factor)}, scaled(muscle, factor)).measure().depth_m, depth * factor);
  }
}

TEST(SurfaceDepth, WhatItRemembersOnlyMakesItFaster) {
  const TriangleMesh bone = make_capsule(0.1, 0.3, 20);
  const TriangleMesh muscle = make_sphere(0.2, 3);
  Scene scene({bone}, muscle);
  for (int frame = 0; frame < 40; ++frame) {
    const RigidMotion pose = RigidMotion::about_axis(Vec3::UnitY(), {0, 0, 0.5}, 0.05 * frame);
    std::vector<Vec3> positions = muscle.vertices;
    for (Vec3& p : positions) p += Vec3(0.25 + 0.06 * std::sin(0.3 * frame), 0.02 * std::cos(9 * p.x() + frame), 0.1);
    const double fresh = Scene({bone}, muscle).measure(positions, {pose}).depth_m;
    ASSERT_NEAR(scene.measure(positions, {pose}).depth_m, fresh, tolerance(bone, fresh)) << frame;
  }
}

TEST(SurfaceDepth, AFaceThatWasLookedAtMayJumpOntoTheBone) {
  // A knob near a corner lets the meter look at the face while its middle is far above the ridge.
  TriangleMesh bone = make_roof(0.3, 0.4, 2);
  append(bone, moved(make_box({0.1, 0.1, 0.1}, 1), Vec3(0.1, 1.2, 1)));
  Scene scene({bone}, face_at(1));
  EXPECT_EQ(scene.measure().depth_m, 0);
  EXPECT_GT(scene.work(), 0);
  expect_depth(scene.measure(face_at(-0.1).vertices, {RigidMotion{}}), 0.06, bone);
}

TEST(SurfaceDepth, OpenBoneGivesADepthThatIsReached) {
  TriangleMesh bone = make_box({1, 1, 1}, 2);
  bone.triangles.pop_back();
  const TriangleMesh muscle = moved(make_box({0.3, 0.3, 0.3}, 2), Vec3(0, 0, 1.1));
  const DeepestSurfacePoint found = Scene({bone}, muscle).measure();
  EXPECT_GE(found.depth_m, 0.199);
  const std::vector<Bone> bones{bone_of(bone)};
  EXPECT_NEAR(Referee(bones, 0).signed_distance(0, found.point_m), -found.depth_m, 1e-12);
}

TEST(SurfaceDepth, FlushInAGrooveIsSettledAtOnce) {
  const TriangleMesh block = grooved_block();
  ASSERT_GT(naive::winding_number(block, Vec3(0.1, 0.2, -0.5)), 0.9);
  ASSERT_LT(naive::winding_number(block, Vec3(0.1, 0.2, 0.5)), 0.1);
  Scene scene({block}, groove_filling());
  const DeepestSurfacePoint found = scene.measure(10'000'000);
  EXPECT_LE(found.depth_m, 1e-12);
  EXPECT_LE(found.bound_m, 2 * tolerance(block, 0));
  EXPECT_LT(scene.work(), 100'000) << "faces were split down along the valley line";

  Scene sunk({block}, moved(groove_filling(), Vec3(0.01, 0, -0.02)));
  const DeepestSurfacePoint deepest = sunk.measure(10'000'000);
  expect_depth(deepest, std::hypot(0.01, 0.02), block);  // to the valley line
  EXPECT_LT(sunk.work(), 1'000'000);
}

TEST(SurfaceDepth, WhatTheBudgetDoesNotSufficeForIsInTheBound) {
  const TriangleMesh roof = make_roof(0.3, 0.4, 2);
  for (const double z : {-0.1, -0.01, 1e-5}) {
    const double depth = std::max(0.0, -z * 0.6);
    double last_bound = std::numeric_limits<double>::infinity();
    for (const long budget : {0L, 20L, 100L, 1000L}) {
      Scene scene({roof}, face_at(z));
      const DeepestSurfacePoint found = scene.measure(budget);
      EXPECT_LE(found.depth_m, depth + 1e-12);
      EXPECT_GE(found.bound_m, depth - 1e-12);
      EXPECT_LE(found.bound_m, last_bound);
      EXPECT_LE(scene.work(), budget + 1000);
      last_bound = found.bound_m;
      if (budget == 0) {
        EXPECT_GT(found.bound_m, 0.2) << "a bound that nothing was asked for";
      }
    }
  }
}

TEST(SurfaceDepth, ABoundOfNodesInsideIsFinite) {
  const TriangleMesh bone = make_box({1, 1, 1}, 1);
  Scene scene({bone}, moved(make_box({0.1, 0.1, 0.1}, 1), Vec3(0, 0, 0.5)));
  const DeepestSurfacePoint found = scene.measure(0L);
  EXPECT_GE(found.depth_m, 0.5) << "that of the nodes is always known";
  EXPECT_GE(found.bound_m, 0.6);
  EXPECT_LE(found.bound_m, 1);
}

TEST(SurfaceDepth, AroundANodeIsTheDeepestPointOfItsTriangles) {
  const TriangleMesh bone = make_capsule(0.1, 0.3, 10);
  TriangleMesh muscle = moved(make_box({0.2, 0.02, 0.2}, 2), Vec3(0.05, 0.1, 0.1));
  for (Vec3& vertex : muscle.vertices) vertex.y() -= 0.2 * vertex.x() * vertex.x();
  Scene scene({bone}, muscle);
  const auto [found, complete] = scene.measure_around_nodes();
  EXPECT_TRUE(complete);
  const double spacing = 0.01;
  std::vector<double> sampled(muscle.vertices.size(), 0);
  for (const Triangle& triangle : muscle.triangles) {
    const double depth = sampled_depth(bone, muscle.vertices, {triangle}, spacing);
    for (const int node : triangle)
      sampled[static_cast<std::size_t>(node)] = std::max(sampled[static_cast<std::size_t>(node)], depth);
  }
  int inside = 0;
  for (std::size_t node = 0; node < found.size(); ++node) {
    EXPECT_GE(found[node], sampled[node] - tolerance(bone, sampled[node])) << node;
    EXPECT_LE(found[node], sampled[node] + spacing) << node;
    inside += found[node] > 0;
  }
  EXPECT_GT(inside, 3);
  EXPECT_LT(inside, static_cast<int>(found.size()));
  const double deepest = scene.measure().depth_m;
  EXPECT_NEAR(*std::max_element(found.begin(), found.end()), deepest, tolerance(bone, deepest));
}

TEST(SurfaceDepth, AroundNodesNoneOfWhichIsInside) {
  const TriangleMesh roof = make_roof(0.3, 0.4, 2);
  Scene scene({roof}, face_at(-0.1));
  for (const double depth : scene.measure_around_nodes().depths_m) EXPECT_NEAR(depth, 0.06, tolerance(roof, 0.06));
  EXPECT_EQ(scene.measure_around_nodes(0L).depths_m, std::vector<double>(3, 0.0)) << "nothing was asked for";
  EXPECT_FALSE(scene.measure_around_nodes(0L).complete);
  EXPECT_EQ(Scene({roof}, face_at(0.1)).measure_around_nodes().depths_m, std::vector<double>(3, 0.0));
}

TEST(SurfaceDepth, AFreeNodeCountsWhereItsTrianglesDoNot) {
  const TriangleMesh bone = make_box({1, 1, 1}, 1);
  TriangleMesh muscle;
  muscle.vertices = {{0, 0, 0.4}, {0.1, 0, 3}, {0, 0.1, 3}};
  muscle.triangles = {{0, 1, 2}};
  EXPECT_EQ(Scene({bone}, muscle, {-1, 0, 0}).measure_around_nodes().depths_m, (std::vector<double>{0.6, 0, 0}));
}

TEST(SurfaceDepth, AskingAroundNodesChangesNoLaterAnswer) {
  const TriangleMesh bone = make_capsule(0.1, 0.3, 20);
  const TriangleMesh muscle = make_sphere(0.2, 3);
  Scene usual({bone}, muscle), asked({bone}, muscle);
  for (int frame = 0; frame < 40; ++frame) {
    const RigidMotion pose = RigidMotion::about_axis(Vec3::UnitY(), {0, 0, 0.5}, 0.005 * frame);
    std::vector<Vec3> positions = muscle.vertices;
    for (Vec3& p : positions)
      p += Vec3(0.25 + 0.06 * std::sin(0.03 * frame), 0.02 * std::cos(9 * p.x() + 0.1 * frame), 0.1);
    const DeepestSurfacePoint expected = usual.measure(positions, {pose});
    const DeepestSurfacePoint found = asked.measure(positions, {pose});
    ASSERT_EQ(found.depth_m, expected.depth_m) << frame;
    ASSERT_EQ(found.bound_m, expected.bound_m) << frame;
    ASSERT_EQ(asked.work(), usual.work()) << frame;
    asked.measure_around_nodes(positions, {pose});
  }
}

TEST(SurfaceDepth, TrianglesWithoutAreaAreHarmless) {
  const TriangleMesh bone = make_box({1, 1, 1}, 1);
  TriangleMesh muscle;
  muscle.vertices = {{-2, 0, 0.7}, {2, 0, 0.7}, {-2, 0, 0.7}};
  muscle.triangles = {{0, 1, 2}, {0, 0, 0}};
  expect_depth(Scene({bone}, muscle).measure(), 0.3, bone);
}

}  // namespace
}  // namespace musclebench
