#include "core/scene/wanted.hpp"

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/scene/tests/scene_errors.hpp"

namespace musclebench {
namespace {

SceneRequest wanting(const std::string& wanted) {
  SceneRequest request;
  request.name = request.file = "wanted.toml";
  request.text = wanted + R"(
[loop]
frames = 4
[[bone]]
name = "plate"
mesh = "synthetic:box"
[muscle]
name = "ball"
mesh = "synthetic:box"
)";
  request.synthetic_mesh = [](const std::string&) { return make_box(Vec3(1, 1, 1), 1); };
  return request;
}

TEST(Wanted, AreTheUsualLimitsWhereASceneSaysNothing) {
  const Wanted usual = read_scene(wanting("")).wanted;
  EXPECT_FALSE(usual.is_given);
  EXPECT_DOUBLE_EQ(usual.surface_m, 1e-4);
  EXPECT_DOUBLE_EQ(usual.volume_share, 0.01);
  EXPECT_DOUBLE_EQ(usual.returned_m, 2e-3);
  EXPECT_FALSE(usual.nothing_passes || usual.moment_arm_m);
  EXPECT_TRUE(usual.own_values.empty());
  EXPECT_TRUE(read_scene(wanting("[wanted]\n")).wanted.is_given);
}

TEST(Wanted, AreWhatTheSceneSaysAndTheCommandLineOverIt) {
  SceneRequest request = wanting("[wanted]\nsurface_mm = 0.5\nvolume_percent = 2\nnothing_passes = true\n");
  request.wanted_overrides = {{"surface_mm", 0.25}};
  const Wanted wanted = read_scene(request).wanted;
  EXPECT_DOUBLE_EQ(wanted.surface_m, 2.5e-4);
  EXPECT_DOUBLE_EQ(wanted.volume_share, 0.02);
  EXPECT_TRUE(wanted.nothing_passes);
  EXPECT_TRUE(asks_for(wanted, Requirement::muscle_depth) && asks_for(wanted, Requirement::volume));
  EXPECT_TRUE(asks_for(wanted, Requirement::self_passage));
  EXPECT_FALSE(asks_for(wanted, Requirement::returned_shape) || asks_for(wanted, Requirement::whole_surface));
  EXPECT_TRUE(asks_for(read_scene(wanting("[wanted]\nreturns_mm = 2\n")).wanted, Requirement::returned_shape));
}

TEST(Wanted, AreRefusedWhereTheyMeanNothing) {
  expect_mentions(error_of(wanting("[wanted]\nsurface_m = 0.1\n")), {"wanted.toml:2", "surface_m", "surface_mm"});
  expect_mentions(error_of(wanting("[wanted]\nsurface_mm = 0\n")), {"wanted.toml:2", "surface_mm"});
  expect_mentions(error_of(wanting("[wanted]\neffects = \"auto\"\n")), {"wanted.toml:2", "effects", "above"});
  // Arms take fibres, and these a bone that turns.
  expect_mentions(error_of(wanting("[wanted]\nmoment_arm_mm = 1\n")), {"moment_arm_mm", "motion"});
}

}  // namespace
}  // namespace musclebench
