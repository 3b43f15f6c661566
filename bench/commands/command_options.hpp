#pragma once

#include <map>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>

#include "backends/registry.hpp"
#include "bench/cases/scene_source.hpp"
#include "bench/results/recorded_scene.hpp"

namespace musclebench {

/// How a command line names a scene and changes its loop.
struct SceneOptions {
  SceneChoice choice;
  std::vector<std::string> loop;
  std::vector<std::string> motion;
  std::vector<std::string> meshes;
  int frames = 0;  ///< 0: the preset's
};

/// Adds the argument `scene` and the options that change it.
void add_scene_options(CLI::App& command, SceneOptions& options);

/// All that the options change of the loop. Throws InputError.
std::map<std::string, ParameterValue> loop_overrides(const SceneOptions& options);
/// With all that the options say of it. Throws InputError.
SceneChoice choice_of(const SceneOptions& options);

/// Reads the scene, notes and prints its warnings. Throws InputError.
Scene load_scene(const SceneOptions& options);
void print_warnings(const std::string& scene, const std::vector<SceneWarning>& warnings);

/// Adds the argument `recording`, which it returns, and the options that say where its scene is.
CLI::Option* add_recorded_scene_options(CLI::App& command, RecordedScene& options);

/// How a command line names a backend.
struct BackendOptions {
  std::string backend;
  std::string response;  ///< empty: the scene's, or the backend's own
  std::vector<std::string> parameters;
  std::vector<std::string> colliders;  ///< see choose_collider_backends
  int threads = 1;
};

void add_backend_options(CLI::App& command, BackendOptions& options);
/// Of commands that run the loop.
void add_collider_option(CLI::App& command, BackendOptions& options);
/// Of commands where nodes get out of bones.
void add_response_option(CLI::App& command, BackendOptions& options);
void add_threads_option(CLI::App& command, int& threads);

/// The checked parameters of `backend`. Throws InputError.
Parameters backend_parameters(const BackendEntry& backend, const std::vector<std::string>& assignments);

/// Of an option that is a length, a time: refuses what is not a positive finite number, which CLI::Range lets pass when
/// it is NaN.
CLI::Validator positive_and_finite();

}  // namespace musclebench
