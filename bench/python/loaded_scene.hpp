#pragma once

#include <mutex>

#include "bench/cases/scene_source.hpp"

namespace musclebench {

/// Of what one thread at a time works with. Recursive: a backend in Python may ask another backend of the same scene.
using InUse = std::recursive_timed_mutex;

/// A scene that Python has loaded. What bones share is built at its first use.
struct LoadedScene {
  explicit LoadedScene(SceneChoice of) : choice(std::move(of)), scene(load_scene(choice)) {}

  SceneChoice choice;
  Scene scene;
  InUse in_use;
};

/// Throws InputError for a number of threads that can't be taken. A process that was forked has one: the others of
/// OpenMP stayed with its parent, and would be waited for.
void require_threads(int threads);

/// Waits for it without the interpreter's lock, which the caller has given up. Throws what Ctrl-C raises in Python.
std::unique_lock<InUse> wait_for(InUse& in_use);

}  // namespace musclebench
