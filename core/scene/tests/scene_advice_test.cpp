#include "core/scene/scene_advice.hpp"

#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

/// A plate of 4 mm that turns about an axis 50 mm away from the ball that it passes, in steps of so many degrees.
Scene plate_beside_a_ball(double step_deg, const std::string& effects) {
  SceneRequest request;
  request.name = request.file = "test.toml";
  request.text = fmt::format(R"(
[loop]
frames = 10
[[bone]]
name = "plate"
mesh = "synthetic:plate"
[bone.motion]
axis = [0, 1, 0]
centre_m = [-0.05, 0, 0]
from_deg = 0
to_deg = {}
course = "there"
[muscle]
name = "ball"
mesh = "synthetic:ball"
[effects.edge_length]
{})",
                             10 * step_deg, effects);
  request.synthetic_mesh = [](const std::string& name) {
    if (name == "plate") return make_box(Vec3(0.02, 0.02, 0.002), 8);
    TriangleMesh ball = make_sphere(0.01, 2);
    for (Vec3& vertex : ball.vertices) vertex.z() += 0.0125;
    return ball;
  };
  return read_scene(request);
}

TEST(StepAgainstThickness, IsThatOfAPlate) {
  const StepAgainstThickness found = step_against_thickness(plate_beside_a_ball(1, ""), 0);
  EXPECT_GT(found.samples, 20);
  EXPECT_NEAR(found.thinnest_m, 0.004, 1e-6);
  // The part of the plate near the ball is about 60 mm from the axis.
  EXPECT_NEAR(found.step_m, 0.06 * 3.14159265 / 180, 2e-4);
  EXPECT_EQ(found.thinner, 0);
}

TEST(SceneAdvice, AsksForAGuardWhereAStepIsLongerThanABoneIsThick) {
  const auto asks = [](double step_deg, const std::string& effects) {
    for (const std::string& line : scene_advice(plate_beside_a_ball(step_deg, effects))) {
      if (line.find("[effects.tunnelling_guard]") == std::string::npos) continue;
      EXPECT_NE(line.find("'plate'"), std::string::npos) << line;
      EXPECT_NE(line.find("4 mm"), std::string::npos) << line;
      return true;
    }
    return false;
  };
  EXPECT_TRUE(asks(6, ""));   // 6 mm
  EXPECT_FALSE(asks(2, ""));  // 2 mm
  EXPECT_FALSE(asks(6, "[effects.tunnelling_guard]\n"));
}

TEST(SceneAdvice, AsksForAVolumeWhereNoneIsKept) {
  const auto asks = [](const std::string& effects) {
    const auto advice = scene_advice(plate_beside_a_ball(1, effects));
    return !advice.empty() && advice.back().find("[effects.volume]") != std::string::npos;
  };
  EXPECT_TRUE(asks(""));
  EXPECT_FALSE(asks("[effects.volume]\n"));
  EXPECT_FALSE(asks("[effects.local_volume]\n"));
}

}  // namespace
}  // namespace musclebench
