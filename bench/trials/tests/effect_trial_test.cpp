// Trials of the scenes that show an effect, without it: what a run leaves is known from them.
#include "bench/trials/effect_trial.hpp"

#include <algorithm>
#include <ostream>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/cases/scene_source.hpp"
#include "bench/trials/effect_search.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {
namespace {

Scene scene_without(const std::string& scene, const std::string& effect) {
  SceneChoice choice;
  choice.scene = scene;
  choice.effect_overrides = {{"test", effect, true}};
  return load_scene(choice);
}

bool shows_passage(const RequiredFigure& figure) {
  return figure.requirement == Requirement::bone_passage && !figure.holds();
}

RunResult run_of(const Scene& scene, const std::vector<int>& judged_frames) {
  const BackendEntry& backend = exact_backend();
  RunCase run{{scene, backend, Parameters(backend.parameters, {}, backend.name)}};
  run.judged_frames = judged_frames;
  return run_case(run, [](int /*frames*/) {});
}

TEST(EffectTrial, ShowsWhatPassesWithoutAGuard) {
  const Scene scene = scene_without("effects/tunnelling_guard", "tunnelling_guard");
  const EffectTrial trial = try_effects(scene, {}, {});
  ASSERT_TRUE(trial.is_whole());
  EXPECT_EQ(trial.frames, scene.loop.frames);
  ASSERT_EQ(trial.shapes.size(), 8U);
  const RequiredFigure* passed = find_figure(trial.figures, Requirement::bone_passage);
  ASSERT_NE(passed, nullptr);
  EXPECT_EQ(passed->value, static_cast<double>(scene.muscle_mesh.vertices.size()));
}

TEST(EffectTrial, EndsWhereAFrameShowsEnough) {
  const Scene scene = scene_without("effects/tunnelling_guard", "tunnelling_guard");
  const EffectTrial trial = try_effects(scene, {.shows_enough = shows_passage}, {});
  EXPECT_TRUE(trial.was_stopped);
  EXPECT_LT(trial.frames, scene.loop.frames);
}

/// Nodes are followed through frames that are not judged, or those that pass between two of them would be missed.
TEST(EffectTrial, FollowedFramesSeeWhatJudgedOnesSee) {
  const Scene scene = scene_without("effects/tunnelling_guard", "tunnelling_guard");
  const RunResult judged = run_of(scene, {});
  const RunResult followed = run_of(scene, {scene.loop.frames});
  EXPECT_EQ(judged.state_hash, followed.state_hash);
  ASSERT_EQ(judged.records.size(), followed.records.size());
  for (std::size_t i = 0; i < judged.records.size(); ++i) {
    EXPECT_EQ(judged.records[i].tunnelled_nodes, followed.records[i].tunnelled_nodes) << i;
    EXPECT_EQ(judged.records[i].depth.max_depth_m, followed.records[i].depth.max_depth_m) << i;
    EXPECT_EQ(followed.records[i].judged, i + 1 == judged.records.size()) << i;
  }
}

/// What a scene chooses for a bone is not asked: coarse voxels would see other contacts.
TEST(EffectTrial, IsExactWhateverTheSceneChooses) {
  Scene scene = scene_without("effects/tunnelling_guard", "tunnelling_guard");
  const EffectTrial exact = try_effects(scene, {}, {});
  for (SceneBoneContact& contact : scene.bone_contacts) {
    contact.backend.name = "voxel";
    contact.backend.parameters = {{"cells", std::int64_t{8}}};
  }
  const EffectTrial chosen = try_effects(scene, {}, {});
  ASSERT_EQ(chosen.refusal, "");
  EXPECT_EQ(exact.shapes, chosen.shapes);
}

TEST(EffectTrial, ASceneThatBacktracksIsRefused) {
  Scene scene = scene_without("effects/tunnelling_guard", "tunnelling_guard");
  scene.response = ResponseKind::backtrack;
  EXPECT_NE(try_effects(scene, {}, {}).refusal.find("backtrack"), std::string::npos);
}

/// Of a large scene with few frames, all are judged, and with no smaller budget.
TEST(EffectTrial, FewFramesAreAllJudged) {
  SceneChoice choice;
  choice.scene = "synthetic/iliacus";
  choice.loop_overrides = {{"frames", std::int64_t{19}}};
  const EffectTrial trial = try_effects(load_scene(choice), {}, {});
  EXPECT_TRUE(trial.judged_all_frames);
}

/// Of these an effect is missing, which the search finds, or one that does as well.
struct Missing {
  std::string effect;
  std::vector<std::string> found;
};

void PrintTo(const Missing& missing, std::ostream* out) { *out << missing.effect; }

class EffectChoiceTest : public testing::TestWithParam<Missing> {};

TEST_P(EffectChoiceTest, FindsWhatAShowSceneLacks) {
  Scene scene = scene_without("effects/" + GetParam().effect, GetParam().effect);
  const EffectChoice choice = choose_effects(scene, [](const Scene& tried, const TrialRequest& request,
                                                       const std::string&) { return try_effects(tried, request, {}); });
  std::vector<std::string> found;
  for (const AddedEffect& added : choice.added) found.push_back(added.effect);
  EXPECT_EQ(found, GetParam().found);
}

INSTANTIATE_TEST_SUITE_P(ShowScenes, EffectChoiceTest,
                         testing::Values(Missing{"attachment", {"attachment"}},
                                         Missing{"self_contact", {"self_contact"}},
                                         Missing{"tunnelling_guard", {"tunnelling_guard"}},
                                         Missing{"no_passage", {"no_passage"}}, Missing{"multi_bone", {}}),
                         [](const auto& each) { return each.param.effect; });

}  // namespace
}  // namespace musclebench
