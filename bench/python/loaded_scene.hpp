#pragma once

#include <mutex>

#include "bench/cases/scene_source.hpp"

namespace musclebench {

/// A scene that Python has loaded. What bones share is built at its first use, so one thread at a time works with the
/// scene. The mutex is recursive: a backend in Python may ask another backend of the same scene.
struct LoadedScene {
  explicit LoadedScene(SceneChoice of) : choice(std::move(of)), scene(load_scene(choice)) {}

  SceneChoice choice;
  Scene scene;
  std::recursive_mutex in_use;
};

}  // namespace musclebench
