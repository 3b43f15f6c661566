#include "bench/hard/fuzz.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {
namespace {

const std::vector<std::string> usual_backends = {"bvh", "sdf"};

TEST(FuzzScene, IsFixedByItsSeed) {
  std::set<std::string> texts;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const std::string text = text_of(fuzz_scene(seed, usual_backends), "synthetic:", "");
    EXPECT_EQ(text, text_of(fuzz_scene(seed, usual_backends), "synthetic:", ""));
    texts.insert(text);
  }
  EXPECT_EQ(texts.size(), 20U);
}

TEST(FuzzScene, MostCanBeReadAndNoneThrowsAnythingElse) {
  int read = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    try {
      (void)read_fuzz_scene(fuzz_scene(seed, usual_backends));
      ++read;
    } catch (const InputError&) {
      // One line with the cure.
    }
  }
  EXPECT_GT(read, 15);
}

/// Each is a part of the program that a draw has to reach.
TEST(FuzzScene, DrawsWhatScenesMayHave) {
  int several = 0, touching = 0, attached = 0, with_fibres = 0, with_tables = 0, with_response = 0, with_backends = 0;
  constexpr int scenes = 200;
  for (std::uint64_t seed = 0; seed < scenes; ++seed) {
    const FuzzScene scene = fuzz_scene(seed, usual_backends);
    several += scene.muscles.size() > 1 ? 1 : 0;
    touching += scene.muscle_contact ? 1 : 0;
    attached += scene.attachments.empty() ? 0 : 1;
    with_fibres += std::ranges::any_of(scene.muscles, &FuzzBody::has_fibres) ? 1 : 0;
    with_tables += tables_of(scene).empty() ? 0 : 1;
    with_response += scene.response.empty() ? 0 : 1;
    with_backends += std::ranges::any_of(scene.bones, [](const FuzzBody& bone) { return !bone.backend.empty(); });
  }
  for (const int count : {several, touching, attached, with_fibres, with_tables, with_response, with_backends}) {
    EXPECT_GT(count, scenes / 20);
  }
}

/// A ball that is free, over a bone that stands still, with or without gravity; `to_deg` turns the bone.
FuzzScene ball_and_plate(double time_step_s) {
  FuzzScene scene;
  scene.backend = "bvh";
  scene.muscles.resize(1);
  scene.muscles[0].shape = "ball";
  scene.bones.resize(1);
  scene.bones[0].shape = "plate";
  scene.bones[0].place.translation_m.z() = 0.1;
  scene.loop = {{"frames", std::int64_t{50}}, {"substeps", std::int64_t{4}}, {"time_step_s", time_step_s}};
  scene.effects = {{"edge_length", {}}};
  return scene;
}

TEST(FuzzScene, AFallOutOfTheSceneIsRightAndADivergenceIsWrong) {
  FuzzScene falls = ball_and_plate(0.01);  // 2 s: 20 m
  falls.effects["gravity"] = {};
  const FuzzOutcome fallen = run_fuzz_scene(falls, 60);
  EXPECT_EQ(fallen.status, "diverged") << fallen.wrong << fallen.refused;
  EXPECT_EQ(fallen.wrong, "");
  FuzzScene thrown = ball_and_plate(0.01);
  thrown.effects["margin"] = {{"thickness_m", 1.0}};  // laid out of it at once, which gives a speed
  thrown.loop["depenetration_m_per_s"] = 0.0;
  const FuzzOutcome wrong = run_fuzz_scene(thrown, 60);
  EXPECT_NE(wrong.wrong.find("diverged: frame "), std::string::npos) << wrong.status << wrong.refused;
}

/// Without each piece in turn: what is left is a smaller scene, and in the end there is none.
TEST(FuzzScene, GetsSmallerUntilNothingCanBeLeftOut) {
  FuzzScene scene = fuzz_scene(3, usual_backends);
  int steps = 0;
  for (std::vector<FuzzScene> smaller = smaller_scenes(scene); !smaller.empty(); smaller = smaller_scenes(scene)) {
    scene = smaller.front();
    ASSERT_LT(++steps, 200);
  }
  EXPECT_EQ(scene.bones.size(), 1U);
  EXPECT_TRUE(scene.effects.empty());
  EXPECT_EQ(scene.muscles.size(), 1U);
  EXPECT_TRUE(scene.muscles[0].defect.empty());
  EXPECT_TRUE(scene.attachments.empty());
  EXPECT_TRUE(scene.response.empty());
}

}  // namespace
}  // namespace musclebench
