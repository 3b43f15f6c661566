#include "bench/micro/micro_scene.hpp"

#include <algorithm>
#include <cstdlib>
#include <random>

#include "bench/cases/scene_source.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

const Scene& micro_scene() {
  static const Scene loaded = [] {
    const char* name = std::getenv("MUSCLEBENCH_MICRO_SCENE");
    return load_scene({name != nullptr ? name : "synthetic/iliacus", "", "", {}});
  }();
  return loaded;
}

std::vector<Vec3> points_near(const Bone& bone, std::size_t count) {
  const std::vector<Vec3>& vertices = micro_scene().muscle_mesh.vertices;
  const Eigen::AlignedBox3d box = bounding_box(bone.surface.mesh.vertices);
  std::mt19937 random(1);
  std::normal_distribution<double> jitter(0, 0.002);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 point = vertices[i % vertices.size()] + Vec3(jitter(random), jitter(random), jitter(random));
    if (box.contains(point)) {
      points.push_back(point);
    }
  }
  return points;
}

std::vector<Vec3> points_far(const Bone& bone, std::size_t count) {
  const Eigen::AlignedBox3d box = bounding_box(bone.surface.mesh.vertices);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> share(-0.05, 1.05);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 shares(share(random), share(random), share(random));
    points.push_back(box.min() + shares.cwiseProduct(box.sizes()));
  }
  return points;
}

std::vector<std::string> raced_backends() {
  std::vector<std::string> names;
  for (const BackendEntry& backend : backend_registry()) {
    if (parse_toml(backend.study, backend.name).contains("race")) {
      names.push_back(backend.name);
    }
  }
  return names;
}

std::string control_backend() {
  const auto& backends = backend_registry();
  const auto found = std::find_if(backends.begin(), backends.end(), [](const BackendEntry& backend) {
    return parse_toml(backend.study, backend.name)["control"].value_or(false);
  });
  return found->name;
}

double guessed_step_ms(const BackendEntry& backend) {
  const toml::table study = parse_toml(backend.study, backend.name);
  return study["series"][0]["step_ms"].value_or(0.0);
}

Settings run_settings(const std::string& backend) {
  Settings settings;
  const char* folder = std::getenv("MUSCLEBENCH_MICRO_STRUCTURES");
  const ParameterSpec* storage = find_parameter(find_backend(backend).parameters, ParameterRole::storage);
  if (folder != nullptr && storage != nullptr) {
    settings[storage->name] = std::string(folder);
  }
  return settings;
}

Settings cold_settings(const std::string& backend) {
  Settings settings = run_settings(backend);
  if (const auto* cache = find_parameter(find_backend(backend).parameters, ParameterRole::clearance_cache)) {
    settings[cache->name] = std::string("off");
  }
  return settings;
}

std::unique_ptr<CollisionBackend> built_backend(const std::string& name, const Settings& settings,
                                                std::span<const Bone> bones, const TriangleMesh& muscle, int threads) {
  const BackendEntry& entry = find_backend(name);
  std::unique_ptr<CollisionBackend> backend = entry.make(Parameters(entry.parameters, settings, name));
  backend->build(bones, muscle, threads);
  return backend;
}

}  // namespace musclebench
