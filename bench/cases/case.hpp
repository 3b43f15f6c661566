#pragma once

#include <string>
#include <vector>

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
  std::vector<ResponseKind> responses = {
      backend.default_response};  ///< one for all, or one a muscle and bone (Scene::bone_pair)
  ColliderBackends colliders = {};
  bool prune = true;  ///< build nothing over bones that the muscles are not expected to touch; changes no contact
};

/// What a user may say of a case beside scene, backend and parameters.
struct CaseChoice {
  std::string response = {};                ///< see choose_responses
  std::vector<std::string> colliders = {};  ///< see choose_collider_backends
  int threads = 1;
  int repetition = 0;
};

/// Why so many threads can't be taken; empty: they can. Threads that share a core and wait for each other at every step
/// are slower than one by far.
std::string refusal_of_threads(long threads);

/// The case of a backend on a scene. Throws InputError where they or what was chosen do not go together.
Case resolve_case(const Scene& scene, const BackendEntry& backend, const Parameters& parameters,
                  const CaseChoice& choice = {});

/// The responses of a case, one for all or one a muscle and bone: what the scene says of the two, else the command line
/// (`--response`; empty: nothing), else the scene for all, else the own one of their backend. Throws InputError where a
/// backend can't serve what was chosen.
std::vector<ResponseKind> choose_responses(const std::string& option, const Scene& scene, const BackendEntry& backend,
                                           const Parameters& parameters, const ColliderBackends& colliders = {});

/// A line for each effect that looks at contacts with bones where no backend finds any.
std::vector<std::string> effects_without_contacts(const Scene& scene, const BackendEntry& backend,
                                                  const Parameters& parameters, const ColliderBackends& colliders = {});

/// Throws InputError where an effect of the scene needs what a backend or a response has not.
void require_what_effects_need(const Scene& scene, const BackendEntry& backend, const Parameters& parameters,
                               const std::vector<ResponseKind>& responses, const ColliderBackends& colliders = {});

}  // namespace musclebench
