// Scenes of several muscles: how they are read, and that muscles which do not touch each other move as if alone.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench/cases/tests/bar_and_ball.hpp"
#include "core/scene/scene_warnings.hpp"
#include "core/scene/tests/scene_errors.hpp"

namespace musclebench {
namespace {

using namespace bar_and_ball;

TEST(ManyMuscles, AreRangesOfNodesAndTriangles) {
  const Scene scene = read_scene(request(both()));
  ASSERT_EQ(scene.muscles.size(), 2U);
  EXPECT_EQ(scene.muscle_names(), "bar + ball");
  const TriangleMesh bar_mesh = mesh_of("bar");
  const TriangleMesh ball_mesh = mesh_of("ball");
  const Body& first = scene.muscles[0].body;
  const Body& second = scene.muscles[1].body;
  EXPECT_EQ(scene.vertices_of(first), bar_mesh.vertices);
  EXPECT_EQ(scene.vertices_of(second), ball_mesh.vertices);
  EXPECT_EQ(scene.mesh_of(second).triangles, ball_mesh.triangles);
  EXPECT_EQ(second.first_node, first.last_node);
  EXPECT_EQ(second.first_triangle, first.last_triangle);
  ASSERT_EQ(scene.attachments.size(), 3U);
  for (const Attachment& attachment : scene.attachments) {
    ASSERT_FALSE(attachment.nodes.empty());
    for (const int node : attachment.nodes) {
      EXPECT_EQ(body_of(scene.bodies(), node), attachment.muscle);
    }
  }
}

TEST(ManyMuscles, MoveToTheBitAsIfEachWereAlone) {
  const auto of_bar = simulated(std::string(bones) + "[muscle]" + bar + attachments_of_bar(), 1);
  const auto of_ball = simulated(std::string(bones) + "[muscle]" + ball + attachment("ball", 0.05), 1);
  for (const int threads : {1, 2, 3}) {
    const auto together = simulated(both(), threads);
    ASSERT_EQ(together.size(), 2U);
    EXPECT_EQ(together[0], of_bar[0]) << threads;
    EXPECT_EQ(together[1], of_ball[0]) << threads;
  }
  EXPECT_GT((of_bar[0][5] - mesh_of("bar").vertices[5]).norm(), 1e-3);
  EXPECT_GT((of_ball[0][5] - mesh_of("ball").vertices[5]).norm(), 1e-3);
}

/// The muscle with fibres comes second: its nodes are numbered from another one on.
TEST(ManyMuscles, MoveToTheBitAsIfEachWereAloneInAnyOrder) {
  const auto of_bar = simulated(std::string(bones) + "[muscle]" + bar + attachments_of_bar(), 1);
  const auto together = simulated(
      std::string(bones) + "[[muscle]]" + ball + "[[muscle]]" + bar + attachment("ball", 0.05) + attachments_of_bar(),
      2);
  ASSERT_EQ(together.size(), 2U);
  EXPECT_EQ(together[1], of_bar[0]);
}

TEST(ManyMuscles, ThatPassThroughEachOtherAreWarnedOf) {
  const auto mentions = [](const std::string& text, const std::string& what) {
    return std::ranges::any_of(scene_warnings(read_scene(request(text))), [&](const SceneWarning& warning) {
      return warning.text.find(what) != std::string::npos;
    });
  };
  EXPECT_TRUE(mentions(both(), "pass through each other"));
  EXPECT_FALSE(mentions(all_touch + both(), "pass through each other"));
  EXPECT_FALSE(mentions(std::string(bones) + "[muscle]" + bar + attachments_of_bar(), "pass through each other"));
}

TEST(ManyMuscles, PairsAreAllOrThoseThatAreNamed) {
  const Scene all = read_scene(request(all_touch + both()));
  ASSERT_EQ(all.muscle_pairs.size(), 1U);
  EXPECT_EQ(all.muscle_pairs[0].muscles, (MusclePair{0, 1}));
  EXPECT_EQ(all.muscle_pairs[0].backend.name, "");
  const Scene named = read_scene(request(both() + pair("ball", "bar", "backend = \"fcl\"")));
  ASSERT_EQ(named.muscle_pairs.size(), 1U);
  EXPECT_EQ(named.muscle_pairs[0].muscles, (MusclePair{0, 1}));
  EXPECT_EQ(named.muscle_pairs[0].backend.name, "fcl");
  EXPECT_TRUE(read_scene(request(both())).muscle_pairs.empty());
  EXPECT_EQ(read_scene(request("[contact]\nsteps = 7\n" + both())).response_steps, 7);
  EXPECT_FALSE(named.muscle_pairs[0].response_steps);
  EXPECT_EQ(read_scene(request(both() + pair("ball", "bar", "steps = 9"))).muscle_pairs[0].response_steps, 9);
}

TEST(ManyMuscles, ABoneMayHaveAResponseAndStepsOfItsOwn) {
  const auto with = [](const std::string& more) {
    std::string text = both();
    return request(text.replace(text.find("mesh = \"synthetic:lid\""), 0, more));
  };
  const Scene scene = read_scene(with("response = \"backtrack\"\nsteps = 5\n"));
  EXPECT_FALSE(scene.bone_contacts[0].response);
  EXPECT_EQ(scene.bone_contacts[1].response, ResponseKind::backtrack);
  const BoneResponse plate{ResponseKind::project, 3};
  const BoneResponse lid{ResponseKind::project, 5};
  EXPECT_EQ(scene.responses({ResponseKind::project}), (std::vector{plate, lid, plate, lid}));
  const BoneResponse back{ResponseKind::backtrack, 5};
  EXPECT_EQ(
      scene.responses({ResponseKind::project, ResponseKind::backtrack, ResponseKind::project, ResponseKind::backtrack}),
      (std::vector{plate, back, plate, back}));
  expect_mentions(error_of(with("response = \"bactrack\"\n")), {"bone[2].response", "did you mean 'backtrack'"});
  expect_mentions(error_of(with("steps = 0\n")), {"bone[2].steps"});
}

TEST(ManyMuscles, WhatIsWrongWithPairsNamesItsKey) {
  const std::string one = std::string(bones) + "[muscle]" + bar + attachments_of_bar();
  expect_mentions(error_of(request(all_touch + one)), {"contact.muscle_contact", "two muscles", "has one"});
  expect_mentions(error_of(request(both() + pair("ball", "bra"))),
                  {"test.toml", "pair[1].muscles", "'bra'", "did you mean 'bar'"});
  expect_mentions(error_of(request(both() + pair("ball", "ball"))), {"pair[1].muscles", "'ball' stands there twice"});
  expect_mentions(error_of(request(both() + pair("ball", "bar") + pair("bar", "ball"))),
                  {"pair[2].muscles", "earlier [[pair]]"});
  expect_mentions(error_of(request(both() + "[[pair]]\nmuscles = [\"ball\"]\n")), {"pair[1].muscles", "two muscles"});
  expect_mentions(error_of(request("[contact]\nmuscle_backend = \"bvh\"\n" + both())),
                  {"contact.muscle_backend", "no muscles touch"});
  for (const char* steps : {"0", "2.5", "1e9"}) {
    expect_mentions(error_of(request("[contact]\nsteps = " + std::string(steps) + "\n" + both())), {"contact.steps"});
    expect_mentions(error_of(request(both() + pair("ball", "bar", "steps = " + std::string(steps)))),
                    {"test.toml", "pair[1].steps"});
  }
  SceneRequest open = request(all_touch + both());
  open.synthetic_mesh = [](const std::string& name) {
    TriangleMesh mesh = mesh_of(name);
    if (name == "ball") mesh.triangles.erase(mesh.triangles.begin());
    return mesh;
  };
  expect_mentions(error_of(open), {"contact.muscle_contact", "muscle 'ball' is open"});
}

TEST(ManyMuscles, WhatIsWrongWithThemNamesItsKey) {
  const std::string two = std::string(bones) + "[[muscle]]" + bar + "[[muscle]]";
  expect_mentions(error_of(request(two + bar)), {"test.toml", "muscle[2].name", "'bar'", "earlier muscle"});
  std::string like_a_bone = both();
  like_a_bone.replace(like_a_bone.find("name = \"ball\""), std::string("name = \"ball\"").size(), "name = \"lid\"");
  expect_mentions(error_of(request(like_a_bone)), {"test.toml", "muscle[2].name", "'lid'", "name of a bone"});
  std::string nameless = both();
  nameless.erase(nameless.find("muscle = \"ball\"\n"), std::string("muscle = \"ball\"\n").size());
  expect_mentions(error_of(request(nameless)), {"attachment[3].muscle", "is missing", "bar or ball"});
  std::string wrong = both();
  wrong.replace(wrong.find("muscle = \"ball\""), std::string("muscle = \"ball\"").size(), "muscle = \"balll\"");
  expect_mentions(error_of(request(wrong)), {"attachment[3].muscle", "'balll'", "did you mean 'ball'"});
  expect_mentions(error_of(request("muscle = []\n" + std::string(bones))), {"muscle", "[[muscle]]"});
}

}  // namespace
}  // namespace musclebench
