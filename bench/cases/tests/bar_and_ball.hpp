#pragma once

#include <string>
#include <vector>

#include "backends/registry.hpp"
#include "bench/cases/case.hpp"
#include "bench/cases/collider_backends.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/prepare_simulation.hpp"
#include "core/scene/read_scene.hpp"

/// Two muscles on a plate that turns, one of them below a lid: the smallest scene of several muscles and bones.
namespace musclebench::bar_and_ball {

inline constexpr const char* bones = R"(
[loop]
frames = 6
substeps = 4
density_kg_per_m3 = 1000.0
bone_motion = "interpolated"
[effects.attachment]
[effects.edge_length]
compliance_m_per_n = 0.01
[effects.volume]
[effects.bending]
[[bone]]
name = "plate"
mesh = "synthetic:plate"
[bone.motion]
axis = [0, 1, 0]
centre_m = [0, 0, 0]
from_deg = 0
to_deg = 25
course = "there"
[[bone]]
name = "lid"
mesh = "synthetic:lid"
)";

inline constexpr const char* bar = R"(
name = "bar"
mesh = "synthetic:bar"
fibres = "between_attachments"
)";
inline constexpr const char* ball = R"(
name = "ball"
mesh = "synthetic:ball"
)";

inline std::string attachment(const std::string& muscle, double x_m, const std::string& bone = "plate",
                              const std::string& z_m = "0.005") {
  const std::string left = std::to_string(x_m - 0.01);
  const std::string right = std::to_string(x_m + 0.01);
  return "\n[[attachment]]\nname = \"of_" + muscle + "\"\nbone = \"" + bone + "\"\nmuscle = \"" + muscle +
         "\"\noutline_m = [[" + left + ", -0.01, " + z_m + "], [" + right + ", -0.01, " + z_m + "], [" + right +
         ", 0.01, " + z_m + "], [" + left + ", 0.01, " + z_m + "]]\ndistance_m = 0.004\n";
}

inline std::string attachments_of_bar() { return attachment("bar", -0.05) + attachment("bar", -0.05, "lid", "0.0416"); }

inline const std::string all_touch = "[contact]\nmuscle_contact = true\n";

inline std::string pair(const std::string& one, const std::string& other, const std::string& more = "") {
  return "\n[[pair]]\nmuscles = [\"" + one + "\", \"" + other + "\"]\n" + more + "\n";
}

inline TriangleMesh shifted(TriangleMesh mesh, const Vec3& by_m) {
  for (Vec3& vertex : mesh.vertices) {
    vertex += by_m;
  }
  return mesh;
}

inline TriangleMesh mesh_of(const std::string& name) {
  if (name == "lid") return shifted(make_box(Vec3(0.02, 0.02, 0.005), 4), Vec3(-0.05, 0, 0.0466));
  if (name == "plate") return make_box(Vec3(0.1, 0.02, 0.005), 4);
  return name == "bar" ? shifted(make_capsule(0.008, 0.01, 12), Vec3(-0.05, 0, 0.0232))
                       : shifted(make_sphere(0.012, 2), Vec3(0.05, 0, 0.0172));
}

/// Pairs of a bone (plate, lid) and a muscle (bar, ball) of `both`.
inline constexpr std::size_t bar_on_plate = 0, ball_on_plate = 1, bar_at_lid = 2, ball_at_lid = 3;

inline SceneRequest request(const std::string& text) {
  SceneRequest made;
  made.name = made.file = "test.toml";
  made.text = text;
  made.synthetic_mesh = mesh_of;
  return made;
}

inline std::string both() {
  return std::string(bones) + "[[muscle]]" + bar + "[[muscle]]" + ball + attachments_of_bar() +
         attachment("ball", 0.05);
}

/// Positions after the scene's frames, by muscle; `options` are those of `--for`, of the case's backend bvh.
inline std::vector<std::vector<Vec3>> simulated(const std::string& text, int threads,
                                                const std::vector<std::string>& options = {}) {
  const Scene scene = read_scene(request(text));
  const BackendEntry& entry = find_backend("bvh");
  const Parameters parameters(entry.parameters, {}, "test");
  const ColliderBackends colliders = choose_collider_backends(options, scene, entry);
  const auto backend = make_backend(scene, entry, parameters, colliders);
  backend->build(scene.bones, scene.muscle_mesh, threads);
  const PreparedSimulation prepared =
      prepare_simulation(scene, *backend, choose_responses("", scene, entry, parameters, colliders), threads,
                         make_contact_methods(scene, colliders, threads));
  for (int frame = 1; frame <= scene.loop.frames; ++frame) {
    prepared.simulation->step_frame(frame);
  }
  std::vector<std::vector<Vec3>> positions;
  for (const Muscle& muscle : scene.muscles) {
    const std::vector<Vec3>& all = prepared.simulation->positions();
    positions.emplace_back(all.begin() + muscle.body.first_node, all.begin() + muscle.body.last_node);
  }
  return positions;
}

}  // namespace musclebench::bar_and_ball
