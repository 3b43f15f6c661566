#include "bench/cases/tests/combination_scene.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "bench/cases/tests/pressed_ball.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {

namespace {

constexpr const char* short_loop = R"(
[loop]
frames = 3
substeps = 4
)";

/// The ball's second end, between which and its foot fibres pull.
constexpr const char* head_of_ball = R"(
[[attachment]]
name = "head"
bone = "rod"
muscle = "ball"
near = "outline"
outline_m = [[-0.006, -0.006, 0.0405], [0.006, -0.006, 0.0405], [0.006, 0.006, 0.0405], [-0.006, 0.006, 0.0405]]
distance_m = 0.002
)";

/// About the ball's lower half, so narrow that the rod, which presses, cannot widen it.
constexpr const char* ring_about_ball = R"(
[[retinaculum]]
name = "ring"
bone = "plate"
muscle = "ball"
centre_m = [0.0, 0.0, 0.0205]
axis = [1.0, 0.0, 0.0]
radius_m = 0.0200001
half_width_m = 0.01
)";

}  // namespace

Scene combination_scene(const std::vector<std::string>& effects, int subdivisions) {
  SceneRequest request;
  request.name = request.file = "combination.toml";
  request.text = short_loop + plate_and_rod(-15) + two_balls + foot_of_ball;
  if (std::ranges::find(effects, "fibre_force") != effects.end()) request.text += head_of_ball;
  if (std::ranges::find(effects, "retinaculum") != effects.end()) request.text += ring_about_ball;
  for (const std::string& effect : effects) request.text += fmt::format("[effects.{}]\n", effect);
  request.synthetic_mesh = [subdivisions](const std::string& name) { return pressed_ball_mesh(name, subdivisions); };
  Scene scene = read_scene(request);
  scene.muscles[0].fibres = {{Vec3(0, 0, 0), Vec3(0, 0, 0.04)}};
  return scene;
}

RunCase combination_case(const Scene& scene, const BackendEntry& backend) {
  RunCase run{{scene, backend, Parameters(backend.parameters, {}, backend.name)}};
  run.colliders = choose_collider_backends({}, scene, backend);
  run.judge = false;
  return run;
}

}  // namespace musclebench
