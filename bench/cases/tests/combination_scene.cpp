#include "bench/cases/tests/combination_scene.hpp"

#include <fmt/format.h>

#include "core/mesh/shapes.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {

namespace {

constexpr const char* scene_without_effects = R"(
[loop]
frames = 3
substeps = 4
[contact]
muscle_contact = true
[[bone]]
name = "plate"
mesh = "synthetic:plate"
[[bone]]
name = "rod"
mesh = "synthetic:rod"
[bone.motion]
axis = [0, 1, 0]
centre_m = [0.05, 0, 0]
from_deg = 0
to_deg = -15
course = "there"
[[muscle]]
name = "ball"
mesh = "synthetic:ball"
[[muscle]]
name = "other"
mesh = "synthetic:other"
[[attachment]]
name = "foot"
bone = "plate"
muscle = "ball"
outline_m = [[-0.01, -0.01, 0], [0.01, -0.01, 0], [0.01, 0.01, 0], [-0.01, 0.01, 0]]
distance_m = 0.002
)";

TriangleMesh moved_by(TriangleMesh mesh, const Vec3& by_m) {
  for (Vec3& vertex : mesh.vertices) vertex += by_m;
  return mesh;
}

TriangleMesh mesh_of(const std::string& name, int subdivisions) {
  if (name == "plate") return moved_by(make_box(Vec3(0.08, 0.04, 0.01), 4), Vec3(0, 0, -0.01));
  if (name == "rod") return moved_by(make_capsule(0.01, 0.02, 16), Vec3(0.034, 0, 0.03));
  return moved_by(make_sphere(0.02, subdivisions), Vec3(name == "ball" ? 0 : -0.0392, 0, 0.0205));
}

}  // namespace

Scene combination_scene(const std::vector<std::string>& effects, int subdivisions) {
  SceneRequest request;
  request.name = request.file = "combination.toml";
  request.text = scene_without_effects;
  for (const std::string& effect : effects) request.text += fmt::format("[effects.{}]\n", effect);
  request.synthetic_mesh = [subdivisions](const std::string& name) { return mesh_of(name, subdivisions); };
  Scene scene = read_scene(request);
  scene.muscles[0].fibres = {{Vec3(0, 0, 0), Vec3(0, 0, 0.04)}};
  return scene;
}

RunCase combination_case(const Scene& scene) {
  const BackendEntry& backend = exact_backend();
  RunCase run{{scene, backend, Parameters(backend.parameters, {}, backend.name)}};
  run.colliders = choose_collider_backends({}, scene, backend);
  run.judge = false;
  return run;
}

}  // namespace musclebench
