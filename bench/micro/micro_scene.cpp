#include "bench/micro/micro_scene.hpp"

#include <algorithm>
#include <cstdlib>

#include "bench/cases/scene_source.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

const Scene& micro_scene() {
  static const Scene loaded = load_micro_scene("");
  return loaded;
}

Scene load_micro_scene(const std::string& preset) {
  const char* source = std::getenv("MUSCLEBENCH_MICRO_SCENE");
  return load_scene({source != nullptr ? source : "synthetic/iliacus", preset, "", {}});
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
