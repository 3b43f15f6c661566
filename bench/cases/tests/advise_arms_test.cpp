#include "bench/cases/advise_arms.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/cases/tests/pressed_ball.hpp"
#include "core/base/input_error.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

constexpr const char* head_of_ball = R"(
[[attachment]]
name = "head"
bone = "rod"
muscle = "ball"
outline_m = [[0.024, -0.01, 0.015], [0.024, 0.01, 0.015], [0.024, 0.01, 0.045], [0.024, -0.01, 0.045]]
distance_m = 0.009
)";

/// A ball between a plate and a rod that is bound to both: the rod turns, and fibres run from one to the other.
Scene bound_between(int frames) {
  SceneRequest request;
  request.name = request.file = "between.toml";
  request.text = fmt::format("[loop]\nframes = {}\n[effects.attachment]\n[effects.edge_length]\n", frames) +
                 plate_and_rod(-10) + one_ball + foot_of_ball + head_of_ball;
  request.synthetic_mesh = [](const std::string& name) { return pressed_ball_mesh(name); };
  request.fibres = FibreRequest{8, "--moment-arm-mm"};
  return read_scene(request);
}

std::optional<Assessment> assessed(const Scene& scene, const ArmInput& input, const Configuration& configuration,
                                   std::string& reason) {
  return assess_arms(scene, configuration, 1, input, reason, [](int /*frames*/) {});
}

TEST(AdviseArms, TheExactBackendHasTheExactArmsAndNoCollisionHasOthers) {
  const Scene scene = bound_between(12);
  int reported = 0;
  const ArmInput input = run_for_arms(scene, 60, [&](int done) { reported = done; });
  EXPECT_EQ(input.frames_run, 12);
  EXPECT_EQ(reported, 12);
  EXPECT_LT(input.floor_m, 1e-6);
  std::string reason;
  const auto exact = assessed(scene, input, {exact_backend().name, {}}, reason);
  ASSERT_TRUE(exact) << reason;
  EXPECT_EQ(exact->max_error_m, 0);
  EXPECT_FALSE(exact->contacts);
  EXPECT_GT(exact->collision_ns.median, 0);
  const auto none = assessed(scene, input, {"null", {}}, reason);
  ASSERT_TRUE(none) << reason;
  EXPECT_GT(none->error_m, 1e-6);
  EXPECT_GE(none->max_error_m, none->error_m);
}

TEST(AdviseArms, WithoutTimeTheMotionIsNotWhole) {
  EXPECT_LT(run_for_arms(bound_between(12), 0, [](int /*frames*/) {}).frames_run, 12);
}

TEST(AdviseArms, TooFewFramesAreRefused) {
  EXPECT_THROW(run_for_arms(bound_between(1), 60, [](int /*frames*/) {}), InputError);
}

}  // namespace
}  // namespace musclebench
