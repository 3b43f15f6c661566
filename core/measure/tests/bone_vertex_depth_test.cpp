#include "core/measure/bone_vertex_depth.hpp"

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/referee/tests/naive_truth.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

DeepestBoneVertex measure(const std::vector<TriangleMesh>& meshes, const TriangleMesh& muscle,
                          std::vector<int> carriers = {}) {
  std::vector<Bone> bones;
  for (const TriangleMesh& mesh : meshes) bones.push_back(bone_of(mesh));
  carriers.resize(muscle.vertices.size(), -1);
  BoneVertexDepthMeter meter(bones, muscle, carriers);
  return meter.measure(std::vector<RigidMotion>(meshes.size()), muscle.vertices);
}

/// A slab with large faces, its lower face at z = 0.
TriangleMesh slab() { return moved(make_box({2, 1, 0.2}, 1), Vec3(0, 0, 0.2)); }

TEST(BoneVertexDepth, ThinSpikeThroughALargeFace) {
  for (const double sunk : {0.15, 0.01, 1e-6}) {
    const TriangleMesh spike = moved(make_spike(0.01, 1), Vec3(0.3, 0.2, sunk));
    const DeepestBoneVertex found = measure({spike}, slab());
    EXPECT_NEAR(found.depth_m, sunk, 1e-15);
    EXPECT_EQ(found.bone, 0);
    EXPECT_EQ(found.vertex, 4);
  }
}

TEST(BoneVertexDepth, SpikeThatComesOutAgainHasNoVertexInside) {
  EXPECT_EQ(measure({moved(make_spike(0.01, 1), Vec3(0.3, 0.2, 0.5))}, slab()).depth_m, 0);
}

TEST(BoneVertexDepth, NoContactIsExactlyZero) {
  const DeepestBoneVertex found = measure({moved(make_spike(0.01, 1), Vec3(0, 0, -1e-9))}, slab());
  EXPECT_EQ(found.depth_m, 0);
  EXPECT_EQ(found.bone, -1);
  EXPECT_EQ(found.vertex, -1);
}

TEST(BoneVertexDepth, SphereInSphere) {
  const TriangleMesh bone = moved(make_sphere(0.3, 4), Vec3(0.9, 0, 0));
  EXPECT_NEAR(measure({bone}, make_sphere(1, 5)).depth_m, 0.4, 2e-3);
}

TEST(BoneVertexDepth, TheMuscleMayBeWoundEitherWay) {
  TriangleMesh muscle = slab();
  for (Triangle& t : muscle.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(measure({moved(make_spike(0.01, 1), Vec3(0.3, 0.2, 0.1))}, muscle).depth_m, 0.1, 1e-15);
}

TEST(BoneVertexDepth, FoldedOverItselfIsStillMuscle) {
  // Two boxes that overlap: winding number 2 in between. The nearest surface of the vertex is a face inside the other.
  TriangleMesh muscle = make_box({1, 1, 1}, 1);
  append(muscle, moved(make_box({1, 1, 1}, 1), Vec3(0, 0, 1.5)));
  EXPECT_NEAR(measure({moved(make_spike(0.01, 5), Vec3(0.3, 0.2, 0.8))}, muscle).depth_m, 0.2, 1e-14);
}

TEST(BoneVertexDepth, WhatABoneCarriesDoesNotCountAgainstIt) {
  const TriangleMesh spike = moved(make_spike(0.01, 1), Vec3(0.3, 0.2, 0.1));
  std::vector<int> carriers(slab().vertices.size(), -1);
  for (std::size_t node = 0; node < carriers.size(); ++node) {
    if (slab().vertices[node].z() == 0) carriers[node] = 0;
  }
  EXPECT_EQ(measure({spike}, slab(), carriers).depth_m, 0);
  for (int& carrier : carriers) carrier = carrier == 0 ? 1 : -1;
  EXPECT_NEAR(measure({spike, moved(spike, Vec3(9, 0, 0))}, slab(), carriers).depth_m, 0.1, 1e-15);
}

TEST(BoneVertexDepth, VerticesThatNoTriangleUsesAreNoBone) {
  TriangleMesh spike = moved(make_spike(0.01, 1), Vec3(0, 0, -1));
  spike.vertices.emplace_back(0, 0, 0.2);
  EXPECT_EQ(measure({spike}, slab()).depth_m, 0);
}

TEST(BoneVertexDepth, ScalesToTheBit) {
  const TriangleMesh bone = moved(make_sphere(0.3, 3), Vec3(0.9, 0.1, 0.2));
  const TriangleMesh muscle = make_sphere(1, 3);
  const double depth = measure({bone}, muscle).depth_m;
  for (const double factor : {0x1p10, 0x1p-10}) {
    EXPECT_EQ(measure({scaled(bone, factor)}, scaled(muscle, factor)).depth_m, depth * factor);
  }
}

/// Brute force: every vertex, every triangle.
double plain_depth(const TriangleMesh& bone, const RigidMotion& pose, const TriangleMesh& muscle) {
  double deepest = 0;
  for (const Vec3& vertex : bone.vertices) {
    const Vec3 point = pose.apply(vertex);
    const double depth = naive::distance(muscle, point);
    if (depth > deepest && naive::winding_number(muscle, point) > 0.5) deepest = depth;
  }
  return deepest;
}

struct FollowedMuscle {
  int touching = 0;
  long work = 0;
};

constexpr int followed_frames = 40;

/// A muscle of `rest` deforms while a bone turns into it and out again; each frame compared with brute force.
FollowedMuscle follow(const TriangleMesh& bone, const TriangleMesh& rest) {
  const std::vector<Bone> bones{bone_of(bone)};
  BoneVertexDepthMeter meter(bones, rest, std::vector<int>(rest.vertices.size(), -1));
  FollowedMuscle result;
  for (int frame = 0; frame < followed_frames; ++frame) {
    const RigidMotion pose = RigidMotion::about_axis(Vec3::UnitZ(), {0.1, 0, 0}, 0.1 * frame);
    TriangleMesh muscle = rest;
    for (Vec3& p : muscle.vertices)
      p += Vec3(-0.2 - 0.2 * std::sin(0.3 * frame), 0.02 * std::cos(9 * p.x() + frame), 0);
    const double plain = plain_depth(bone, pose, muscle);
    const DeepestBoneVertex found = meter.measure(std::vector{pose}, muscle.vertices);
    EXPECT_NEAR(found.depth_m, plain, 1e-12) << frame;
    EXPECT_EQ(found.bound_m, found.depth_m);
    result.touching += plain > 0 ? 1 : 0;
    result.work += meter.last_work();
  }
  return result;
}

TEST(BoneVertexDepth, FollowsADeformingMuscleAndAMovingBone) {
  const TriangleMesh bone = make_capsule(0.1, 0.3, 16);
  const FollowedMuscle closed = follow(bone, moved(make_sphere(0.2, 3), Vec3(0.4, 0, 0)));
  EXPECT_GT(closed.touching, 10);
  EXPECT_LT(closed.touching, followed_frames);
  constexpr long work_of_a_query = 60;
  EXPECT_LT(closed.work, work_of_a_query * followed_frames * static_cast<long>(bone.vertices.size()) / 2);
}

TEST(BoneVertexDepth, AnOpenMuscleTakesHardlyMoreWorkThanAClosedOne) {
  const TriangleMesh bone = make_capsule(0.1, 0.3, 16);
  const TriangleMesh closed = moved(make_sphere(0.2, 3), Vec3(0.4, 0, 0));
  TriangleMesh open = closed;
  open.triangles.resize(open.triangles.size() - 2);
  const FollowedMuscle of_open = follow(bone, open);
  EXPECT_GT(of_open.touching, 10);
  EXPECT_LT(of_open.work, 3 * follow(bone, closed).work);
}

TEST(BoneVertexDepth, WhatTheBudgetDoesNotSufficeForIsInTheBound) {
  const TriangleMesh bone = make_sphere(0.5, 4);
  const TriangleMesh muscle = make_sphere(1, 3);
  const std::vector<Bone> bones{bone_of(bone)};
  BoneVertexDepthMeter meter(bones, muscle, std::vector<int>(muscle.vertices.size(), -1));
  const double plain = plain_depth(bone, {}, muscle);
  constexpr long budget = 5000;
  double deepest = 0;
  int frames = 0;
  for (; deepest < plain - 1e-12 && frames < 1000; ++frames) {
    const DeepestBoneVertex found = meter.measure(std::vector<RigidMotion>(1), muscle.vertices, budget);
    EXPECT_LE(found.depth_m, plain + 1e-12);
    EXPECT_GE(found.bound_m, plain - 1e-12);
    EXPECT_LT(meter.last_work(), budget + 5000) << "one cluster more";
    deepest = std::max(deepest, found.depth_m);
  }
  EXPECT_GT(frames, 1) << "the budget should not suffice at once";
  EXPECT_LT(frames, 1000) << "what was left out comes first in the next frame";
  const TriangleMesh far = moved(bone, Vec3(5, 0, 0));
  BoneVertexDepthMeter apart(std::vector{bone_of(far)}, muscle, std::vector<int>(muscle.vertices.size(), -1));
  EXPECT_EQ(apart.measure(std::vector<RigidMotion>(1), muscle.vertices, 0).bound_m, 0) << "outside the muscle's box";
}

/// A corner that was far away at the first look is looked at again when the muscle has come as far as that.
TEST(BoneVertexDepth, AVertexIsSafeOnlyAsFarAsItWasAway) {
  const std::vector<Bone> bones = {bone_of(make_box({3, 3, 3}, 1))};
  const TriangleMesh ball = make_sphere(0.5, 3);
  BoneVertexDepthMeter meter(bones, ball, std::vector<int>(ball.vertices.size(), -1));
  const std::vector<RigidMotion> poses(1);
  EXPECT_EQ(meter.measure(poses, moved(ball, Vec3(3.6, 0, 0)).vertices).depth_m, 0);
  EXPECT_NEAR(meter.measure(poses, moved(ball, Vec3(3.1, 3, 3)).vertices).depth_m, 0.4, 0.01);
}

}  // namespace
}  // namespace musclebench
