#include "core/scene/reach.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

void add_bone(Scene& scene, const std::string& name, const Vec3& at_m, const BoneMotion& motion = {}) {
  Bone bone{name, {make_box(Vec3(0.05, 0.05, 0.05), 1), true, {}}};
  for (Vec3& vertex : bone.surface.mesh.vertices) vertex += at_m;
  scene.bones.push_back(std::move(bone));
  scene.motions.push_back(motion);
}

/// A ball of radius 0.1 about the origin, whose box has a diagonal of 0.346.
Scene scene_of_ball() {
  Scene scene;
  scene.add_muscle("ball", make_sphere(0.1, 2));
  scene.loop.frames = 10;
  return scene;
}

TEST(Reach, ABoneFartherThanTheMarginIsUntouched) {
  Scene scene = scene_of_ball();
  const double margin_m = 0.25 * 0.2 * std::numbers::sqrt3;
  add_bone(scene, "near", Vec3(0.15 + margin_m - 0.001, 0, 0));
  add_bone(scene, "far", Vec3(0.15 + margin_m + 0.001, 0, 0));
  const std::vector<BoneReach> reach = predict_reach(scene);
  EXPECT_FALSE(reach[0].is_untouched);
  EXPECT_TRUE(expected_boxes(reach)[1].isEmpty());
  EXPECT_NEAR(reach[1].distance_m, margin_m + 0.001, 1e-9);
  EXPECT_NEAR(reach[1].margin_m, margin_m, 1e-9);
}

TEST(Reach, ABoneThatMovesInIsNot) {
  Scene scene = scene_of_ball();
  const Vec3 far(0, 0, 1);
  add_bone(scene, "still", far);
  BoneRotation half_turn{Vec3::UnitY(), Vec3(0, 0, 0.5), {0, 1}, {0, std::numbers::pi}, false};
  add_bone(scene, "comes", far, {{half_turn}});
  half_turn.there_and_back = true;
  add_bone(scene, "comes and goes", far, {{half_turn}});
  const std::vector<BoneReach> reach = predict_reach(scene);
  EXPECT_TRUE(reach[0].is_untouched);
  EXPECT_FALSE(reach[1].is_untouched);
  EXPECT_FALSE(reach[2].is_untouched);
}

/// The muscle goes where its bound nodes are carried.
TEST(Reach, ABoneThatTheMuscleIsCarriedToIsNot) {
  Scene scene = scene_of_ball();
  add_bone(scene, "carrier", Vec3(0.08, 0, 0));
  add_bone(scene, "target", Vec3(0, 0, 1));
  const BoneMotion half_turn{{{Vec3::UnitY(), Vec3(0, 0, 0.5), {0, 1}, {0, std::numbers::pi}, false}}};
  scene.motions[0] = half_turn;
  EXPECT_TRUE(predict_reach(scene)[1].is_untouched) << "nothing is bound";
  Attachment attachment{"all", 0, 0, {}, {}};
  for (int node = 0; node < static_cast<int>(scene.muscle_mesh.vertices.size()); node += 3) {
    attachment.nodes.push_back(node);
  }
  scene.attachments.push_back(attachment);
  EXPECT_FALSE(predict_reach(scene)[1].is_untouched);
  scene.attachments.clear();
  scene.attach_at_first_contact = true;
  EXPECT_FALSE(predict_reach(scene)[1].is_untouched) << "nodes in the carrier's box will be bound";
}

TEST(Reach, AnOpenBoneIsNeverUntouched) {
  Scene scene = scene_of_ball();
  add_bone(scene, "open", Vec3(1, 0, 0));
  EXPECT_TRUE(predict_reach(scene)[0].is_untouched);
  scene.bones[0].surface.mesh.triangles.pop_back();
  EXPECT_FALSE(predict_reach(scene)[0].is_untouched);
}

TEST(Reach, MusclesAreExpectedInTheirBoxesWithTheMarginAsTheBoneSeesThem) {
  Scene scene = scene_of_ball();
  const double half_m = 0.1 + 0.25 * 0.2 * std::numbers::sqrt3;
  add_bone(scene, "still", Vec3(0.1, 0, 0));
  const BoneMotion half_turn{{{Vec3::UnitY(), Vec3(0, 0, 0.5), {0, 1}, {0, std::numbers::pi}, false}}};
  add_bone(scene, "turns", Vec3(0.1, 0, 0), half_turn);
  const std::vector<BoneReach> reach = predict_reach(scene);
  EXPECT_LT((reach[0].box.min() - Vec3::Constant(-half_m)).norm(), 1e-3 * half_m);
  EXPECT_LT((reach[0].box.max() - Vec3::Constant(half_m)).norm(), 1e-3 * half_m);
  // Seen from the bone the ball goes half around (0, 0, 0.5).
  EXPECT_NEAR(reach[1].box.max().z(), 1 + half_m, 2e-3);
  EXPECT_NEAR(reach[1].box.min().z(), -half_m, 2e-3);
  EXPECT_GT(reach[1].box.sizes().x(), 0.5 + 2 * half_m - 1e-3);
  scene.bones[0].surface.mesh.triangles.pop_back();
  EXPECT_FALSE(expected_boxes(predict_reach(scene))[0].sizes().array().isFinite().any()) << "it is open";
}

TEST(Reach, OfSeveralMusclesTheNearestCounts) {
  Scene scene = scene_of_ball();
  add_bone(scene, "far", Vec3(1, 0, 0));
  TriangleMesh other = make_sphere(0.1, 2);
  for (Vec3& vertex : other.vertices) vertex.x() += 2;
  scene.add_muscle("other", other);
  EXPECT_TRUE(predict_reach(scene)[0].is_untouched) << "between them, and near none";
  scene.bones[0] = Bone{"near", {make_box(Vec3(0.95, 0.05, 0.05), 1), true, {}}};
  EXPECT_FALSE(predict_reach(scene)[0].is_untouched);
}

}  // namespace
}  // namespace musclebench
