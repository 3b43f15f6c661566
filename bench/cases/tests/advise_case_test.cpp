#include "bench/cases/advise_case.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/cases/tests/pressed_ball.hpp"
#include "core/base/input_error.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

/// A ball that a rod presses against a plate.
Scene pressed(const std::string& keys_of_the_rod = "", int frames = 6) {
  SceneRequest request;
  request.name = request.file = "pressed.toml";
  request.text = fmt::format("[loop]\nframes = {}\n[effects.edge_length]\n", frames) +
                 plate_and_rod(-30, keys_of_the_rod) + one_ball;
  request.synthetic_mesh = [](const std::string& name) { return pressed_ball_mesh(name); };
  return read_scene(request);
}

const auto unreported = [](int /*done*/, int /*total*/) {};

std::optional<Assessment> assessed(const Scene& scene, const Configuration& configuration, std::string& reason) {
  const AdviceInput input = run_exactly(scene, 60, [](int /*frames*/) {});
  return assess(scene, configuration, {}, *input.frames, reason, unreported);
}

TEST(AdviseCase, TheExactBackendErrsByNothingAndCoarseVoxelsDo) {
  const Scene scene = pressed();
  std::string reason;
  const auto exact = assessed(scene, {exact_backend().name, {}}, reason);
  ASSERT_TRUE(exact) << reason;
  EXPECT_LT(exact->max_error_m, 1e-12);
  EXPECT_EQ(exact->contacts->missed + exact->contacts->wrong, 0);
  EXPECT_GT(exact->contacts->real, 0);
  const auto coarse = assessed(scene, {"voxel", {{"cells", std::int64_t{8}}}}, reason);
  ASSERT_TRUE(coarse) << reason;
  EXPECT_GT(coarse->contacts->wrong, 0);
}

TEST(AdviseCase, RowsOfFramesAndTheDeepestBendAreKept) {
  const Scene scene = pressed("", 200);  // a stride of 5: five frames in a row, then twenty without
  int reported = 0;
  const AdviceInput input = run_exactly(scene, 60, [&](int done) { reported = done; });
  EXPECT_EQ(input.frames_run, 200);
  EXPECT_EQ(reported, 200);
  EXPECT_EQ(input.frames->header().frames(), 200 / 25 * 5 + 1);
  EXPECT_EQ(run_exactly(scene, 0, [](int /*frames*/) {}).frames_run, 0);
}

/// A bone's own backend stays, whatever is tried for the others; where all have one there is nothing to choose.
TEST(AdviseCase, WhatTheSceneSettlesIsKept) {
  const Scene settled = pressed("backend = \"voxel\"\nparameters = { cells = 8 }\n");
  EXPECT_NO_THROW(require_a_choice(settled));
  std::string reason;
  const auto exact_plate = assessed(settled, {exact_backend().name, {}}, reason);
  ASSERT_TRUE(exact_plate) << reason;
  EXPECT_GT(exact_plate->contacts->wrong, 0);  // of the rod's voxels
  Scene all_settled = settled;
  all_settled.bone_contacts[0].backend = all_settled.bone_contacts[1].backend;
  EXPECT_THROW(require_a_choice(all_settled), InputError);
}

TEST(AdviseCase, ATrialIsJudgedOverTheWholeMotion) {
  const Scene scene = pressed("", 12);
  const auto exact = try_out(scene, {exact_backend().name, {}}, 1, 60, {});
  ASSERT_TRUE(exact);
  EXPECT_EQ(exact->frames, 12);
  EXPECT_LT(exact->node_depth_m, 1e-9);
  const auto none = try_out(scene, {"null", {}}, 1, 60, {});
  ASSERT_TRUE(none);
  EXPECT_GT(none->node_depth_m, 1e-4);
  EXPECT_FALSE(try_out(scene, {exact_backend().name, {}}, 1, 0, {}));
}

/// FCL's collision of surfaces has no surface of its own to look for: its own run says how deep it lets nodes.
TEST(AdviseCase, WhatCantBeAskedAboutPointsIsTried) {
  if (std::ranges::none_of(backend_registry(), [](const BackendEntry& entry) { return entry.name == "fcl"; })) {
    GTEST_SKIP() << "built without fcl";
  }
  const Scene scene = pressed();
  std::string reason;
  const auto surfaces = assessed(scene, {"fcl", {}}, reason);
  ASSERT_TRUE(surfaces) << reason;
  ASSERT_TRUE(surfaces->trial);
  EXPECT_EQ(surfaces->error_m, surfaces->trial->node_depth_m);
  const AdviceInput input = run_exactly(scene, 60, [](int /*frames*/) {});
  EXPECT_FALSE(assess(scene, {"fcl", {}}, {.trial_seconds = 0}, *input.frames, reason, unreported));
  EXPECT_NE(reason.find("single points"), std::string::npos);
}

TEST(AdviseCase, WithoutContactsThereIsNothingToJudge) {
  Scene scene = pressed();
  for (Vec3& vertex : scene.muscle_mesh.vertices) vertex += Vec3(0, 0, 10);
  std::string reason;
  EXPECT_FALSE(assessed(scene, {exact_backend().name, {}}, reason));
  EXPECT_NE(reason.find("in no bone"), std::string::npos);
}

}  // namespace
}  // namespace musclebench
