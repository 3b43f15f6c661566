#include "core/contact/backends_by_bone.hpp"

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

TEST(BackendsByBone, AnswerAsOneBackendOfAllBones) {
  const std::vector<Bone> bones(3);
  const TriangleMesh no_muscle;
  ShapeBackend one(shapes());
  one.build(bones, no_muscle, 1);
  std::vector<BackendsByBone::Part> parts;
  parts.push_back({std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[0]}), 1});
  parts.push_back({std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[1], shapes()[2]}), 2});
  BackendsByBone several(std::move(parts));
  several.build(bones, no_muscle, 1);

  std::vector<Vec3> positions;
  std::vector<int> nodes;
  for (int i = 0; i < 400; ++i) {
    positions.emplace_back(-1.5 + 0.1 * (i % 60), 0.2 * (i / 100) - 0.5, -2.4 + 0.4 * (i % 7));
    if (i % 3 != 0) nodes.push_back(i);
  }
  std::vector<RigidMotion> poses(3);
  for (int bone = 0; bone < 3; ++bone) poses[static_cast<std::size_t>(bone)].translation_m = Vec3(0.1 * bone, 0, 0.05);
  one.update(poses, positions);
  several.update(poses, positions);
  std::vector<Contact> expected;
  std::vector<Contact> found;
  one.detect(positions, nodes, expected);
  several.detect(positions, nodes, found);
  ASSERT_GT(expected.size(), 50U);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].node, expected[i].node);
    EXPECT_EQ(found[i].bone, expected[i].bone);
    EXPECT_EQ(found[i].depth_m, expected[i].depth_m);
    EXPECT_EQ(found[i].normal, expected[i].normal);
  }
  for (int bone = 0; bone < 3; ++bone) EXPECT_EQ(several.step_m(bone), one.step_m(bone));
}

TEST(BackendsByBone, CanDoWhatAllOfThemCan) {
  std::vector<BackendsByBone::Part> parts;
  parts.push_back({std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[0]}), 1});
  parts.push_back({std::make_unique<ShapeBackend>(std::vector<Shape>{shapes()[1]}, false), 1});
  const BackendsByBone several(std::move(parts));
  EXPECT_TRUE(several.capabilities().depth);
  EXPECT_FALSE(several.capabilities().point_queries);
}

}  // namespace
}  // namespace musclebench
