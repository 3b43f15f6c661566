#pragma once

#include <memory>
#include <string>
#include <vector>

#include "backends/registry.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Who detects contacts with what, where that is not left to the case's backend. With its default parameters.
struct ColliderBackends {
  std::vector<const BackendEntry*> of_bones = {};  ///< one a bone, nullptr: the case's; empty: that for all
  std::vector<const BackendEntry*> of_pairs = {};  ///< one for each of the scene's muscle pairs
};

/// For each bone and each pair of muscles what the options say (`--for`: texts COLLIDER=BACKEND, where a collider is a
/// bone, or `muscles`), else the scene; between muscles at last the first exact backend that can follow a surface which
/// deforms. Throws InputError for a name that is none, and for a backend that can't do it.
ColliderBackends choose_collider_backends(const std::vector<std::string>& options, const Scene& scene,
                                          const BackendEntry& backend);

/// An unbuilt backend with its default parameters.
std::unique_ptr<CollisionBackend> make_default(const BackendEntry& entry);

/// The unbuilt backend of a case: one for all bones, or several of which each answers for some.
std::unique_ptr<CollisionBackend> make_backend(const BackendEntry& backend, const Parameters& parameters,
                                               const ColliderBackends& colliders);

/// What sees to the scene's muscle pairs: a detector for each backend that is asked for.
std::vector<std::unique_ptr<MuscleContactDetector>> make_muscle_detectors(const Scene& scene,
                                                                          const ColliderBackends& colliders,
                                                                          int threads);

}  // namespace musclebench
