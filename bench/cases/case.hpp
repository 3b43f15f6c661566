#pragma once

#include <string>

#include "bench/cases/collider_backends.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// What every measurement of one backend on one scene resolves to.
struct Case {
  const Scene& scene;
  const BackendEntry& backend;
  Parameters parameters;  ///< of the backend
  int threads = 1;
  int repetition = 0;
  ResponseKind response = backend.default_response;
  ColliderBackends colliders = {};
};

/// The response of a case: what the command line says (`--response`; empty: nothing), else the scene, else the
/// backend's own. Throws InputError where the backend can't serve what was chosen.
ResponseKind choose_response(const std::string& option, const Scene& scene, const BackendEntry& backend,
                             const Parameters& parameters, const ColliderBackends& colliders = {});

}  // namespace musclebench
