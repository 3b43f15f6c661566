#include "core/scene/check/auto_effects.hpp"

#include <filesystem>

#include "core/base/input_error.hpp"
#include "core/scene/check/tests/check_fixture.hpp"

namespace musclebench {
namespace {

SceneRequest request_of(const std::string& text) {
  SceneRequest request;
  request.name = request.file = "test.toml";
  request.text = text;
  request.synthetic_mesh = check_mesh_named;
  request.preset_text = [](const std::string& /*name*/) {
    return "[loop]\nframes = 7\ntime_step_s = 0.1234567890123456789\n[effects.damping]\nrate_per_s = 3.3\n"
           "[effects.bending]\n";
  };
  return request;
}

Scene resolved(const SceneRequest& request) {
  Scene scene = read_scene(request);
  if (scene.auto_effects.wanted) {
    add_advised_effects(scene);
    scene.auto_effects.resolved_text = resolved_scene_text(request, scene);
  }
  return scene;
}

std::vector<std::string> names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneEffect& effect : scene.effects) names.push_back(effect.name);
  return names;
}

/// Two muscles over the edge of a plate that is thinner than a step, and that one of them is bound to.
std::string body_text() {
  return "[loop]\nframes = 10\n" + bone_text("plate", turning(70)) + muscle_text("ball") + muscle_text("other") +
         attachment_text("plate", "ball", 0.0015);
}

using Names = std::vector<std::string>;

TEST(AutoEffects, AddWhatTheCheckerAdvises) {
  const Scene scene = resolved(request_of("effects = \"auto\"\n" + body_text()));
  EXPECT_EQ(names(scene), (Names{"attachment", "edge_length", "volume", "surface_contact", "tunnelling_guard"}));
  ASSERT_EQ(scene.muscle_pairs.size(), 1U);
  EXPECT_EQ(scene.muscle_pairs[0].muscles, (MusclePair{0, 1}));
  ASSERT_EQ(scene.auto_effects.added.size(), 6U);
  for (const AddedEffect& added : scene.auto_effects.added) {
    EXPECT_FALSE(added.rule.empty());
    EXPECT_FALSE(added.reason.empty());
  }
}

TEST(AutoEffects, LeaveASceneAloneThatDoesNotAsk) {
  const Scene scene = resolved(request_of(body_text()));
  EXPECT_TRUE(names(scene).empty());
  EXPECT_TRUE(scene.muscle_pairs.empty());
  EXPECT_TRUE(resolved(request_of(body_text() + "[effects]\nauto = false\n")).effects.empty());
}

TEST(AutoEffects, StandBesideWhatTheSceneNamesAndKeepsOut) {
  const Scene scene = resolved(request_of("preset = \"any\"\n" + body_text() +
                                          "[contact]\nmuscle_contact = false\n[effects]\nauto = true\nbending = false\n"
                                          "surface_contact = false\n[effects.volume]\npressure = 1.5\n"));
  EXPECT_EQ(names(scene), (Names{"damping", "attachment", "edge_length", "volume", "tunnelling_guard"}));
  EXPECT_EQ(scene.effects[0].parameters.number("rate_per_s"), 3.3) << "the preset's";
  EXPECT_EQ(scene.effects[3].parameters.number("pressure"), 1.5) << "the scene's";
  EXPECT_TRUE(scene.muscle_pairs.empty());
  for (const AddedEffect& added : scene.auto_effects.added) EXPECT_NE(added.effect, "volume");
}

TEST(AutoEffects, AreAskedForByTheCommandLineToo) {
  SceneRequest request = request_of(body_text() + "[effects]\nauto = false\nvolume = false\n");
  request.auto_effects = true;
  EXPECT_EQ(names(resolved(request)), (Names{"attachment", "edge_length", "surface_contact", "tunnelling_guard"}));
}

TEST(AutoEffects, KeepOutWhatTheCommandLineTakesOut) {
  SceneRequest request = request_of("preset = \"any\"\neffects = \"auto\"\n" + body_text());
  request.effect_overrides = {{.location = "--no-effect volume", .name = "volume", .is_removed = true},
                              {.location = "--no-effect bending", .name = "bending", .is_removed = true},
                              {.location = "--effect gravity", .name = "gravity"}};
  const Names found = names(resolved(request));
  for (const char* out : {"volume", "bending"}) EXPECT_EQ(std::ranges::count(found, out), 0) << out;
  for (const char* in : {"gravity", "damping", "surface_contact"}) EXPECT_EQ(std::ranges::count(found, in), 1) << in;
}

TEST(AutoEffects, OtherWordsAreRefused) {
  const auto error = [](const std::string& text) {
    try {
      (void)read_scene(request_of(text + body_text()));
    } catch (const InputError& refused) {
      return std::string(refused.what());
    }
    return std::string("no error");
  };
  EXPECT_NE(error("effects = \"all\"\n").find("test.toml:1: effects: has to be \"auto\""), std::string::npos);
  EXPECT_NE(error("effects = 3\n").find("effects"), std::string::npos);
  EXPECT_NE(error("[effects]\nauto = 3\n").find("effects.auto: has to be true or false"), std::string::npos);
  EXPECT_NE(error("effects = \"auto\"\n[effects.volume]\n").find("test.toml:3: [effects.NAME] tables cannot follow"),
            std::string::npos)
      << error("effects = \"auto\"\n[effects.volume]\n");
  EXPECT_NE(error("[effects]\nautp = true\n").find("did you mean 'auto'?"), std::string::npos);
}

TEST(ResolvedScene, IsTheSameSceneWithoutPresetOrAuto) {
  SceneRequest request = request_of("title = \"a \\\"title\\\"\"\npreset = \"any\"\n" + body_text() +
                                    "[effects]\nauto = true\nbending = false\n[effects.tunnelling_guard]\n"
                                    "rule = \"angle\"\n");
  request.loop_overrides = {{"substeps", std::int64_t{5}}};
  request.mesh_overrides = {{"split_muscles", std::int64_t{1}}};
  const Scene scene = resolved(request);
  SceneRequest again = request_of(scene.auto_effects.resolved_text);
  again.preset_text = {};
  const Scene read = read_scene(again);
  EXPECT_EQ(read.title, "a \"title\"");
  EXPECT_TRUE(read.preset.empty());
  EXPECT_FALSE(read.auto_effects.wanted);
  EXPECT_EQ(loop_values(read.loop), loop_values(scene.loop));
  EXPECT_EQ(read.loop.substeps, 5);
  EXPECT_EQ(read.mesh_splits.split_muscles, 1);
  EXPECT_EQ(names(read), names(scene));
  for (std::size_t i = 0; i < std::min(read.effects.size(), scene.effects.size()); ++i) {
    EXPECT_EQ(read.effects[i].parameters.values(), scene.effects[i].parameters.values()) << scene.effects[i].name;
  }
  ASSERT_EQ(read.muscle_pairs.size(), 1U);
  EXPECT_EQ(read.attachments.front().nodes, scene.attachments.front().nodes);
  EXPECT_EQ(read.muscle_mesh.vertices, scene.muscle_mesh.vertices);
  const BoneRotation& read_back = read.motions.front().rotations.front();
  EXPECT_EQ(read_back.angles_rad, scene.motions.front().rotations.front().angles_rad);
  EXPECT_TRUE(read_back.axis == scene.motions.front().rotations.front().axis);
}

TEST(ResolvedScene, KeepsFirstContactAndTellsItsReasons) {
  const Scene scene = resolved(request_of("attachment = \"first_contact\"\neffects = \"auto\"\n" +
                                          bone_text("plate", turning(1)) + muscle_text("ball")));
  const std::string& text = scene.auto_effects.resolved_text;
  EXPECT_TRUE(read_scene(request_of(text)).attach_at_first_contact);
  EXPECT_NE(text.find("# Added [volume]: "), std::string::npos) << text;
}

TEST(ResolvedScene, KeepsItsSourceAndItsRings) {
  const SceneRequest request = request_of("[source]\nlicence = \"CC BY 4.0\"\ncite = [\"one\"]\n" + bone_text("plate") +
                                          muscle_text("ball") + ring_text("ball", 0.0101) + "[effects.retinaculum]\n");
  const Scene read = read_scene(request_of(resolved_scene_text(request, read_scene(request))));
  EXPECT_EQ(read.source.licence, "CC BY 4.0");
  EXPECT_EQ(read.source.citations, std::vector<std::string>{"one"});
  ASSERT_EQ(read.retinacula.size(), 1U);
  EXPECT_EQ(read.retinacula[0].radius_m, 0.0101);
}

/// The pose of the plate in the middle of the motion, of the scene and of its resolved text.
void expect_same_motion(const SceneRequest& request) {
  const Scene scene = read_scene(request);
  std::vector<RigidMotion> poses, same;
  scene.poses_at(7, poses);
  const std::string text = resolved_scene_text(request, scene);
  read_scene(request_of(text)).poses_at(7, same);
  EXPECT_EQ(same[0].rotation, poses[0].rotation) << text;
  EXPECT_EQ(same[0].translation_m, poses[0].translation_m) << text;
  EXPECT_FALSE(poses[0].rotation.isIdentity(1e-3)) << text;
}

TEST(ResolvedScene, HasAllMotionsOfABone) {
  const auto listed = [](double degrees) { return "[" + turning(degrees).insert(13, "]"); };
  const auto scene_of = [](const std::string& motions) {
    return request_of("[loop]\nframes = 10\n" + bone_text("plate", motions) + muscle_text("ball"));
  };
  expect_same_motion(scene_of(listed(70) + listed(20)));
  expect_same_motion(scene_of("motion = {axis = [0, 1, 0], centre_m = [0, 0, 0], from_deg = 0, to_deg = 30}\n"));
  for (const std::string& one : {listed(70), turning(70)}) {
    SceneRequest request = scene_of(one);
    request.motion_overrides = {{"to_deg", 20.0}};
    expect_same_motion(request);
  }
}

}  // namespace
}  // namespace musclebench
