#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "bench/cases/run_case.hpp"
#include "bench/cases/scene_source.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {

inline nlohmann::ordered_json manifest_in(const std::filesystem::path& folder) {
  std::ifstream in(folder / "run.json");
  return nlohmann::ordered_json::parse(in);
}

/// A ball beside a box, made by hand: read in no time.
inline Scene plain_scene() {
  Scene scene;
  scene.name = "plain";
  scene.add_muscle("muscle", make_sphere(0.02, 1));
  Bone box;
  box.name = "box";
  box.surface.mesh = make_box({0.01, 0.01, 0.01}, 1);
  for (Vec3& vertex : box.surface.mesh.vertices) vertex.x() += 0.1;
  scene.bone_meshes.push_back({"box", "", box.surface.mesh});
  scene.bones.push_back(box);
  scene.motions.emplace_back();
  scene.loop.frames = 2;
  return scene;
}

/// A few frames of a small muscle.
inline Scene small_scene(std::int64_t frames = 3) {
  return load_scene({"synthetic/adductor_brevis", "paper", "", {{"frames", frames}}});
}

inline RunCase case_of(const Scene& scene, const std::string& backend,
                       const std::map<std::string, ParameterValue>& parameters = {}) {
  const BackendEntry& entry = find_backend(backend);
  return {{scene, entry, Parameters(entry.parameters, parameters, entry.name)}};
}

inline RunResult result_of(const RunCase& run) {
  return run_case(run, [](int) {});
}

}  // namespace musclebench
