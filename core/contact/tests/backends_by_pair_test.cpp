#include "core/contact/backends_by_pair.hpp"

#include <gtest/gtest.h>

#include "core/contact/tests/shape_backend.hpp"

namespace musclebench {
namespace {

std::vector<Shape> shapes() {
  Shape first = ball(Vec3(0, 0, 0), 1);
  Shape second = half_space(Vec3::UnitZ(), -2);
  Shape third = ball(Vec3(3, 0, 0), 1.5);
  first.step_m = 0.1;
  second.step_m = 0.2;
  third.step_m = 0.3;
  return {first, second, third};
}

/// Two muscles, the nodes of one after those of the other.
std::vector<Body> two_muscles() { return {{"first", 0, 250, 0, 1}, {"second", 250, 400, 1, 3}}; }

struct Queries {
  std::vector<Vec3> positions;
  std::vector<int> nodes;
  std::vector<RigidMotion> poses{3};
};

Queries queries() {
  Queries result;
  for (int i = 0; i < 400; ++i) {
    result.positions.emplace_back(-1.5 + 0.1 * (i % 60), 0.2 * (i / 100) - 0.5, -2.4 + 0.4 * (i % 7));
    if (i % 3 != 0) result.nodes.push_back(i);
  }
  for (int bone = 0; bone < 3; ++bone) {
    result.poses[static_cast<std::size_t>(bone)].translation_m = Vec3(0.1 * bone, 0, 0.05);
  }
  return result;
}

std::vector<Contact> contacts_of(CollisionBackend& backend, const Queries& asked) {
  std::vector<Contact> found;
  backend.update(asked.poses, asked.positions);
  backend.detect(asked.positions, asked.nodes, found);
  return found;
}

void expect_same(const std::vector<Contact>& found, const std::vector<Contact>& expected) {
  ASSERT_GT(expected.size(), 50U);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].node, expected[i].node);
    EXPECT_EQ(found[i].bone, expected[i].bone);
    EXPECT_EQ(found[i].depth_m, expected[i].depth_m);
    EXPECT_EQ(found[i].normal, expected[i].normal);
  }
}

TEST(BackendsByPair, AnswerAsOneBackendOfAllBones) {
  const std::vector<Bone> bones(3);
  const TriangleMesh no_muscle;
  ShapeBackend one(shapes());
  one.build(bones, no_muscle, 1);
  std::vector<BackendsByPair::Part> parts;
  parts.push_back({std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[0]}), 0, 1});
  parts.push_back({std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[1], shapes()[2]}), 1, 2});
  BackendsByPair several(std::move(parts));
  several.build(bones, no_muscle, 1);
  expect_same(contacts_of(several, queries()), contacts_of(one, queries()));
  for (int bone = 0; bone < 3; ++bone) EXPECT_EQ(several.step_m(bone), one.step_m(bone));
}

/// Of the first two bones the muscles have backends of their own, of the third one together.
TEST(BackendsByPair, AnswerAsOneBackendOfAllMuscles) {
  const std::vector<Bone> bones(3);
  const TriangleMesh mesh{std::vector<Vec3>(400), {{0, 1, 2}, {250, 251, 252}, {251, 252, 253}}};
  ShapeBackend one(shapes());
  one.build(bones, mesh, 1);
  const std::vector<Body> muscles = two_muscles();
  std::vector<Shape> finer = {shapes()[0], shapes()[1]};
  for (Shape& shape : finer) shape.step_m /= 2;
  auto of_first = std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[0], shapes()[1]});
  auto of_second = std::make_unique<ShapeBackend>(finer);
  const ShapeBackend& asked_of_first = *of_first;
  const ShapeBackend& asked_of_second = *of_second;
  std::vector<BackendsByPair::Part> parts;
  parts.push_back({std::move(of_first), 0, 2, {muscles[0]}});
  parts.push_back({std::move(of_second), 0, 2, {muscles[1]}});
  parts.push_back({std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[2]}), 2, 1});
  BackendsByPair several(std::move(parts));
  several.build(bones, mesh, 1);

  expect_same(contacts_of(several, queries()), contacts_of(one, queries()));
  ASSERT_EQ(asked_of_first.queried.size(), 1U);
  EXPECT_LT(asked_of_first.queried[0].back(), 250);
  EXPECT_GE(asked_of_second.queried[0].front(), 250);
  EXPECT_EQ(asked_of_first.queried[0].size() + asked_of_second.queried[0].size(), queries().nodes.size());
  EXPECT_EQ(asked_of_first.surface().triangles.size(), 1U);
  EXPECT_EQ(asked_of_second.surface().triangles.size(), 2U);
  EXPECT_EQ(asked_of_second.surface().vertices.size(), 400U);
  EXPECT_EQ(several.step_m(0), finer[0].step_m);
  EXPECT_EQ(several.step_m(2), shapes()[2].step_m);
}

/// Of a node of one muscle the other's backend is not asked at all.
TEST(BackendsByPair, AskNobodyAboutNodesThatAreNotTheirs) {
  const std::vector<Bone> bones(1);
  const TriangleMesh mesh{std::vector<Vec3>(400), {{0, 1, 2}, {250, 251, 252}, {251, 252, 253}}};
  auto of_first = std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[0]});
  const ShapeBackend& asked_of_first = *of_first;
  std::vector<BackendsByPair::Part> parts;
  parts.push_back({std::move(of_first), 0, 1, {two_muscles()[0]}});
  parts.push_back({std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[0]}), 0, 1, {two_muscles()[1]}});
  BackendsByPair several(std::move(parts));
  several.build(bones, mesh, 1);
  std::vector<Contact> found;
  several.update(std::vector<RigidMotion>(1), queries().positions);
  several.detect(queries().positions, std::vector<int>{300, 301}, found);
  EXPECT_TRUE(asked_of_first.queried.empty());
}

TEST(BackendsByPair, CanDoWhatAllOfThemCan) {
  std::vector<BackendsByPair::Part> parts;
  parts.push_back({std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[0]}), 0, 1});
  parts.push_back({std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[1]}, false), 1, 1});
  const BackendsByPair several(std::move(parts));
  EXPECT_TRUE(several.capabilities().depth);
  EXPECT_FALSE(several.capabilities().point_queries);
}

}  // namespace
}  // namespace musclebench
