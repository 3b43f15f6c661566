#include "bench/cases/divergence.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "bench/cases/run_case.hpp"
#include "bench/cases/tests/bar_and_ball.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

TEST(Divergence, ANodeFarFromWhereItStartedIsLost) {
  Scene scene;
  scene.add_muscle("muscle", make_box({1, 1, 1}, 1));
  const double diagonal_m = 2 * std::sqrt(3.0);
  const Divergence divergence(scene);
  std::vector<Vec3> positions = scene.muscle_mesh.vertices;
  EXPECT_EQ(divergence.describe(1, positions), "");
  positions[3].x() += 9.9 * diagonal_m;
  EXPECT_EQ(divergence.describe(1, positions), "");
  positions[3].x() += 0.2 * diagonal_m;
  EXPECT_EQ(divergence.describe(7, positions), "frame 7: node 3 left the scene by more than 34.6 m");
  positions[3].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(divergence.describe(7, positions), "");
}

/// Gravity is a force: what carries a node out of the scene is the velocity that it made.
TEST(Divergence, TheCauseIsWhatMovedTheNodeOutOfTheScene) {
  const auto detail = [](const std::string& effects, const std::string& loop) {
    const Scene scene = read_scene(bar_and_ball::request("[loop]\nframes = 50\n" + loop + effects +
                                                         "[[bone]]\nname = \"plate\"\nmesh = \"synthetic:plate\"\n"
                                                         "[[muscle]]" +
                                                         std::string(bar_and_ball::ball)));
    const BackendEntry& backend = find_backend("null");
    const RunResult result = run_case({{scene, backend, Parameters(backend.parameters, {}, "test")}}, [](int) {});
    EXPECT_EQ(result.status, "diverged");
    return result.status_detail;
  };
  const std::string thrown = detail("[effects.gravity]\n", "time_step_s = 0.1\nsubsteps = 4\n");
  EXPECT_NE(thrown.find("moved out by its own velocity in substep "), std::string::npos) << thrown;
  EXPECT_EQ(thrown.find("frame 1:"), std::string::npos) << thrown;
}

}  // namespace
}  // namespace musclebench
