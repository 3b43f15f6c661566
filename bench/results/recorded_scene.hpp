#pragma once

#include <string>

#include "core/recording/recording.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Where the scene of a recording is now.
struct RecordedScene {
  std::string recording;  ///< the file
  std::string scene;      ///< empty: where it was
  std::string data;
};

/// Reads it, without its warnings. Throws InputError where it has changed since.
Scene load_recorded_scene(const RecordingHeader& header, const RecordedScene& options);

}  // namespace musclebench
