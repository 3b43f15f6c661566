#include "core/measure/muscle_depth.hpp"

#include <gtest/gtest.h>

#include "core/measure/passing_tracker.hpp"
#include "core/mesh/shapes.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

/// Two boxes of 2 m, each against the other; the first lies at the origin.
struct TwoBoxes {
  TriangleMesh mesh = make_box({1, 1, 1}, 1);
  JudgedMuscles muscles;
  std::size_t nodes = mesh.vertices.size();
  std::size_t triangles = mesh.triangles.size();

  TwoBoxes() {
    append(mesh, make_box({1, 1, 1}, 1));
    const int first = static_cast<int>(nodes);
    muscles.bodies = {{"one", 0, first, 0, triangles}, {"other", first, 2 * first, triangles, 2 * triangles}};
    muscles.beside = {{1}, {0}};
  }
  [[nodiscard]] std::vector<Vec3> with_other_at(const RigidMotion& pose) const {
    std::vector<Vec3> positions = mesh.vertices;
    for (std::size_t i = nodes; i < positions.size(); ++i) positions[i] = pose.apply(positions[i]);
    return positions;
  }
};

DeepestInMuscle deepest(const TwoBoxes& boxes, const std::vector<Vec3>& positions, double tolerance_m, long queries) {
  MuscleReferee referee(boxes.mesh, boxes.muscles);
  std::vector<Contact> inside;
  referee.judge(positions, inside);
  std::vector<TriangleInMuscle> crossing;
  for (std::size_t t = 0; t < boxes.mesh.triangles.size(); ++t) {
    crossing.push_back({static_cast<int>(t), t < boxes.triangles ? 1 : 0});
  }
  return deepest_in_muscles(referee, boxes.mesh.triangles, positions,
                            triangles_in_muscles(boxes.mesh.triangles, crossing, inside), tolerance_m, queries);
}

TEST(MuscleDepth, OfEdgeOnEdgeIsThatOfNoNode) {
  // Each on an edge, one along x, one along y, 0.2 deep into each other: a point of the one's edge lies 0.2 below the
  // other's edge, 0.2 / sqrt 2 from its faces.
  const TwoBoxes boxes;
  std::vector<Vec3> positions = boxes.with_other_at({});
  const double half = std::numbers::pi / 4;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const bool lower = i < boxes.nodes;
    positions[i] =
        RigidMotion::about_axis(lower ? Vec3::UnitX() : Vec3::UnitY(), Vec3::Zero(), half).apply(positions[i]);
    if (!lower) positions[i].z() += 2 * std::numbers::sqrt2 - 0.2;
  }
  const DeepestInMuscle found = deepest(boxes, positions, 1e-3, 100000);
  EXPECT_TRUE(found.complete);
  EXPECT_NEAR(found.depth_m, 0.2 / std::numbers::sqrt2, 1e-3);
  EXPECT_GE(found.bound_m, 0.2 / std::numbers::sqrt2 - 1e-12);
  EXPECT_EQ(found.other, found.triangle < static_cast<int>(boxes.triangles) ? 1 : 0);
  const DeepestInMuscle cut = deepest(boxes, positions, 1e-6, 40);
  EXPECT_FALSE(cut.complete);
  EXPECT_LE(cut.depth_m, 0.2 / std::numbers::sqrt2 + 1e-12);
  EXPECT_GE(cut.bound_m, 0.2 / std::numbers::sqrt2);
}

TEST(MuscleDepth, WhatIsApartOrTouchesIsNotDeep) {
  const TwoBoxes boxes;
  EXPECT_EQ(deepest(boxes, boxes.with_other_at({Mat3::Identity(), Vec3(3, 0, 0)}), 1e-3, 100000).depth_m, 0);
  EXPECT_LT(deepest(boxes, boxes.with_other_at({Mat3::Identity(), Vec3(2, 0.5, 0.5)}), 1e-3, 2000).depth_m, 1e-12);
}

TEST(MuscleDepth, TrianglesAroundANodeThatIsInsideAreLookedAt) {
  const std::vector<Triangle> triangles{{0, 1, 2}, {2, 3, 4}, {4, 5, 6}};
  const std::vector<TriangleInMuscle> crossing{{1, 7}};
  const std::vector<Contact> inside{{2, 7}, {3, 7}, {6, 8}};
  EXPECT_EQ(triangles_in_muscles(triangles, crossing, inside), (std::vector<TriangleInMuscle>{{0, 7}, {1, 7}, {2, 8}}));
}

/// Of nodes that go through in the step from the first place of the other box to the second.
int passed(const Vec3& from, const Vec3& to, const Vec3& both_by = Vec3::Zero()) {
  const TwoBoxes boxes;
  MuscleReferee referee(boxes.mesh, boxes.muscles);
  PassingTracker tracker(boxes.muscles);
  std::vector<Contact> inside;
  int found = 0;
  for (const Vec3& place : {from, Vec3(to + both_by)}) {
    std::vector<Vec3> positions = boxes.with_other_at({Mat3::Identity(), place});
    for (std::size_t i = 0; i < boxes.nodes && place != from; ++i) positions[i] += both_by;
    referee.judge(positions, inside);
    found = tracker.update(referee, positions);
  }
  return found;
}

TEST(PassingTracker, CountsNodesThatChangedSidesInNoFrameInside) {
  EXPECT_EQ(passed(Vec3(5, 0.5, 0.25), Vec3(-5, 0.5, 0.25)), 4) << "two lines of corners of each";
  EXPECT_EQ(passed(Vec3(5, 0.5, 0.25), Vec3(-5, 0.5, 0.25), Vec3(100, 0, 0)), 4) << "relative to the other";
  EXPECT_EQ(passed(Vec3(5, 0, 2.5), Vec3(-5, 0, 2.5)), 0) << "beside it";
  EXPECT_EQ(passed(Vec3(5, 0.5, 0.25), Vec3(2.5, 0.5, 0.25)), 0) << "not there yet";
  EXPECT_EQ(passed(Vec3(5, 0.5, 0.25), Vec3(1, 0.5, 0.25)), 0) << "inside, where depths are judged";
  EXPECT_EQ(passed(Vec3(5, 1.999, 0.25), Vec3(-5, 1.999, 0.25)), 0) << "it grazed";
}

}  // namespace
}  // namespace musclebench
