#include <algorithm>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/referee/referee.hpp"
#include "core/referee/tests/naive_truth.hpp"

namespace musclebench {
namespace {

std::vector<Bone> two_bones() {
  TriangleMesh second = make_capsule(0.02, 0.05, 24);
  for (Vec3& vertex : second.vertices) vertex += Vec3(0.05, 0, 0);
  return {{"sphere", {make_sphere(0.04, 3), true, {}}}, {"capsule", {second, true, {}}}};
}

std::vector<int> all_nodes(std::size_t count) {
  std::vector<int> nodes(count);
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

RigidMotion random_motion(double angle_rad, double shift_m, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Vec3 axis = Vec3(normal(random), normal(random), normal(random)).normalized();
  const Vec3 shift(normal(random), normal(random), normal(random));
  return {Eigen::AngleAxisd(angle_rad * normal(random), axis).toRotationMatrix(), shift_m * shift};
}

void expect_same_bits(const std::vector<Contact>& left, const std::vector<Contact>& right) {
  ASSERT_EQ(left.size(), right.size());
  for (std::size_t i = 0; i < left.size(); ++i) {
    ASSERT_EQ(left[i].node, right[i].node);
    ASSERT_EQ(left[i].bone, right[i].bone);
    ASSERT_EQ(left[i].depth_m, right[i].depth_m);
    ASSERT_EQ(left[i].normal, right[i].normal);
  }
}

TEST(RefereeJudge, FindsTheNodesInsideInOrder) {
  const std::vector<Bone> bones = two_bones();
  std::mt19937_64 random(1);
  const std::vector<Vec3> positions = naive::cloud(bones[0].surface.mesh, 3000, random);
  std::vector<int> nodes;
  for (int node = 0; node < 3000; node += 2) nodes.push_back(node);
  const std::vector<RigidMotion> poses{random_motion(1, 0.01, random), random_motion(1, 0.01, random)};
  Referee referee(bones, 3000);
  std::vector<Contact> truth{Contact{}};
  referee.judge(poses, positions, nodes, truth);

  std::size_t next = 0;
  for (int bone = 0; bone < 2; ++bone) {
    const RigidMotion& pose = poses[static_cast<std::size_t>(bone)];
    for (const int node : nodes) {
      const Vec3 rest = pose.apply_inverse(positions[static_cast<std::size_t>(node)]);
      const SurfaceDistance found = referee.closest(bone, rest);
      if (!(found.signed_distance_m < 0)) continue;
      ASSERT_LT(next, truth.size());
      EXPECT_EQ(truth[next].bone, bone);
      EXPECT_EQ(truth[next].node, node);
      EXPECT_EQ(truth[next].depth_m, -found.signed_distance_m);
      EXPECT_NEAR((truth[next].normal - pose.rotation * found.normal).norm(), 0, 1e-15);
      // Moved out along the normal by its depth, the node is free.
      const Vec3 freed = rest - found.signed_distance_m * found.normal;
      EXPECT_NEAR(referee.signed_distance(bone, freed), 0, 1e-15);
      ++next;
    }
  }
  EXPECT_EQ(next, truth.size());
  EXPECT_GT(next, 100U);
}

TEST(RefereeJudge, NothingTouchesFarAway) {
  const std::vector<Bone> bones = two_bones();
  Referee referee(bones, 2);
  const std::vector<Vec3> positions{Vec3(1, 0, 0), Vec3(1e3, 1e3, 1e3)};
  std::vector<Contact> truth;
  referee.judge(std::vector<RigidMotion>(2), positions, all_nodes(2), truth);
  EXPECT_TRUE(truth.empty());
  EXPECT_EQ(referee.last_effort().distance_queries, 0);
}

struct ReuseRun {
  long queries_with = 0;
  long queries_without = 0;
  std::size_t contacts = 0;
};

/// Bones and nodes move at random, `step_m` a frame; now and then a node jumps. Judged with distance reuse, with reuse
/// by three threads, and without: the same bits.
ReuseRun run_with_and_without_reuse(const std::vector<Bone>& bones, double step_m, int frames, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Vec3> positions = naive::cloud(bones[0].surface.mesh, 400, random);
  for (const Vec3& point : naive::near_surface(bones[0].surface.mesh, 400, 2e-3, random)) positions.push_back(point);
  const int count = static_cast<int>(positions.size());
  Referee with(bones, count);
  Referee with_threads(bones, count, 3);
  Referee without(bones, count, 1, Referee::DistanceReuse::off);
  std::vector<RigidMotion> poses(bones.size());
  std::vector<Contact> truth;
  std::vector<Contact> answer;
  ReuseRun run;
  for (int frame = 0; frame < frames; ++frame) {
    for (RigidMotion& pose : poses) pose = random_motion(step_m, 0.3 * step_m, random) * pose;
    for (Vec3& position : positions) position += step_m * Vec3(normal(random), normal(random), normal(random));
    std::swap(positions[static_cast<std::size_t>(frame % count)], positions[static_cast<std::size_t>(count / 2)]);
    std::vector<int> nodes = all_nodes(positions.size());
    if (frame % 3 == 1) std::erase_if(nodes, [](int node) { return node % 3 == 0; });
    without.judge(poses, positions, nodes, truth);
    with.judge(poses, positions, nodes, answer);
    expect_same_bits(answer, truth);
    with_threads.judge(poses, positions, nodes, answer);
    expect_same_bits(answer, truth);
    EXPECT_EQ(with.last_effort().distance_queries, with_threads.last_effort().distance_queries);
    if (testing::Test::HasFatalFailure()) return run;
    run.queries_with += with.last_effort().distance_queries;
    run.queries_without += without.last_effort().distance_queries;
    run.contacts += truth.size();
  }
  return run;
}

TEST(RefereeJudge, ReuseChangesNoBit) {
  for (const double step_m : {1e-6, 1e-4, 1e-3, 1e-2}) {
    const ReuseRun run = run_with_and_without_reuse(two_bones(), step_m, 60, 2);
    EXPECT_GT(run.contacts, 1000U);
    EXPECT_LT(run.queries_with, run.queries_without);
  }
}

TEST(RefereeJudge, ReuseSavesMostQueriesOfSmallMotion) {
  const ReuseRun run = run_with_and_without_reuse(two_bones(), 1e-4, 60, 3);
  // Queried again are the nodes inside, for their depth, and a few near the surface.
  EXPECT_LT(static_cast<double>(run.queries_with), 1.5 * static_cast<double>(run.contacts));
  EXPECT_LT(3 * run.queries_with, run.queries_without);
}

TEST(RefereeJudge, ReuseChangesNoBitOnAnOpenSurface) {
  std::vector<Bone> bones = two_bones();
  bones[0].surface.mesh.triangles.resize(bones[0].surface.mesh.triangles.size() * 3 / 4);
  const ReuseRun run = run_with_and_without_reuse(bones, 3e-3, 8, 4);
  EXPECT_GT(run.contacts, 100U);
}

TEST(RefereeJudge, AnOpenSurfaceIsReusedLikeAClosedOne) {
  // A hole of two triangles. Without reuse each of the 800 nodes is queried in each of 60 frames.
  std::vector<Bone> bones = two_bones();
  bones[0].surface.mesh.triangles.resize(bones[0].surface.mesh.triangles.size() - 2);
  const ReuseRun run = run_with_and_without_reuse(bones, 1e-4, 60, 3);
  EXPECT_LT(3 * run.queries_with, run.queries_without);
}

TEST(RefereeJudge, ATieBetweenFacesDoesNotDependOnThePast) {
  const std::vector<Bone> bones{{"box", {make_box(Vec3(0.25, 0.25, 0.25), 1), true, {}}}};
  // Six nodes come from six faces to points as far from one face as from others.
  const std::vector<Vec3> start{{0.2, 0, 0}, {-0.2, 0, 0}, {0, 0.2, 0}, {0, -0.2, 0}, {0, 0, 0.2}, {0, 0, -0.2}};
  const std::vector<RigidMotion> pose(1);
  std::vector<Contact> truth;
  std::vector<Contact> answer;
  for (const Vec3& end : {Vec3(0, 0, 0), Vec3(0.125, 0.125, 0.125), Vec3(-0.125, -0.125, 0), Vec3(0, 0.125, -0.125)}) {
    Referee with(bones, 6);
    Referee without(bones, 6, 1, Referee::DistanceReuse::off);
    with.judge(pose, start, all_nodes(6), answer);
    const std::vector<Vec3> together(6, end);
    with.judge(pose, together, all_nodes(6), answer);
    without.judge(pose, together, all_nodes(6), truth);
    ASSERT_EQ(truth.size(), 6U);
    expect_same_bits(answer, truth);
  }
}

TEST(RefereeJudge, AKnownSideDoesNotOutliveItsClearance) {
  const std::vector<Bone> bones = two_bones();
  Referee referee(bones, 1);
  const std::vector<RigidMotion> poses(2);
  std::vector<Contact> truth;
  const auto contacts_at = [&](double x) {
    referee.judge(poses, std::vector<Vec3>{Vec3(x, 1e-4, 2e-4)}, all_nodes(1), truth);
    return truth.size();
  };
  EXPECT_EQ(contacts_at(-0.05), 0U);
  EXPECT_EQ(contacts_at(-0.03), 1U);
  EXPECT_EQ(contacts_at(-0.0405), 0U);
  EXPECT_EQ(contacts_at(-0.0395), 1U);
  EXPECT_EQ(contacts_at(0.035), 2U);
  EXPECT_EQ(contacts_at(0.06), 1U);
  EXPECT_EQ(contacts_at(0.08), 0U);
}

/// The side of an open surface changes away from it: however small the steps, it is queried again in time.
TEST(RefereeJudge, APathOutThroughAnOpeningInSmallSteps) {
  TriangleMesh open = make_box(Vec3(1, 1, 1), 4);
  std::erase_if(open.triangles, [&](const Triangle& t) {
    return std::ranges::all_of(t, [&](int v) { return open.vertices[static_cast<std::size_t>(v)].z() == 1; });
  });
  const std::vector<Bone> bones = {{"box", {open, false, {}}}};
  const std::vector<RigidMotion> poses(1);
  Referee referee(bones, 1);
  std::vector<Contact> truth;
  int changes = 0;
  bool was_inside = true;
  for (int step = 0; step <= 1000; ++step) {
    const Vec3 point(0.1, 0.2, 0.003 * step);
    referee.judge(poses, std::vector<Vec3>(1, point), all_nodes(1), truth);
    EXPECT_EQ(!truth.empty(), referee.signed_distance(0, point) < 0) << step;
    changes += truth.empty() == was_inside ? 1 : 0;
    was_inside = !truth.empty();
  }
  EXPECT_EQ(changes, 1);
}

TEST(RefereeJudge, TheLeastDistanceIsNeverMoreThanTheDistance) {
  const std::vector<Bone> bones = {{"sphere", {make_sphere(1, 4), true, {}}}};
  Referee referee(bones, 1);
  std::vector<Contact> truth;
  referee.judge(std::vector<RigidMotion>(1), std::vector<Vec3>(1, Vec3(3, 0, 0)), all_nodes(1), truth);
  EXPECT_GT(referee.least_distance(0, 0, {2.9, 0, 0}), 1.5);
  for (const double x : {3.0, 2.5, 2.0, 1.5, 1.1, 0.5}) {
    const Vec3 point(x, 0.1, 0);
    EXPECT_LE(referee.least_distance(0, 0, point), std::abs(referee.signed_distance(0, point)));
  }
}

TEST(RefereeJudge, PositionsThatAreNotFiniteAreInNoBone) {
  const std::vector<Bone> bones = two_bones();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  Referee referee(bones, 3);
  std::vector<Contact> truth;
  std::vector<Vec3> positions{Vec3(nan, 0, 0), Vec3(0, infinity, 0), Vec3(0.001, 0, 0)};
  for (int call = 0; call < 2; ++call) {
    referee.judge(std::vector<RigidMotion>(2), positions, all_nodes(3), truth);
    ASSERT_EQ(truth.size(), 1U);
    EXPECT_EQ(truth[0].node, 2);
  }
  positions.assign(3, Vec3(0.001, 0, 0));
  referee.judge(std::vector<RigidMotion>(2), positions, all_nodes(3), truth);
  EXPECT_EQ(truth.size(), 3U);
}

TEST(RefereeJudge, BytesCountTreesAndNodeCaches) {
  const std::vector<Bone> bones = two_bones();
  const Referee small(bones, 0);
  const Referee large(bones, 1000);
  EXPECT_GT(small.bytes(), 70 * (bones[0].surface.mesh.triangles.size() + bones[1].surface.mesh.triangles.size()));
  EXPECT_GE(large.bytes(), small.bytes() + 2 * 1000 * sizeof(Vec3));
}

}  // namespace
}  // namespace musclebench
