#pragma once

#include <string>

#include <CLI/App.hpp>

#include "core/recording/recording.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Where the scene of a recording is now.
struct RecordedSceneOptions {
  std::string recording;  ///< the file
  std::string scene;      ///< empty: where it was
  std::string data;
};

/// Adds the argument `recording`, which it returns, and the options that say where its scene is.
CLI::Option* add_recorded_scene_options(CLI::App& command, RecordedSceneOptions& options);

/// Reads the scene that was recorded. Throws InputError where it has changed since.
Scene load_recorded_scene(const RecordingHeader& header, const RecordedSceneOptions& options);

}  // namespace musclebench
