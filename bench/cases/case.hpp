#pragma once

#include "backends/registry.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// What every measurement of one backend on one scene resolves to.
struct Case {
  const Scene& scene;
  const BackendEntry& backend;
  Parameters parameters;  ///< of the backend
  int threads = 1;
  int repetition = 0;
};

}  // namespace musclebench
