#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/registry.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// A backend with all of its parameters.
struct BackendChoice {
  const BackendEntry* entry;
  Parameters parameters;

  [[nodiscard]] std::unique_ptr<CollisionBackend> make() const { return entry->make(parameters); }
  friend bool operator==(const BackendChoice& a, const BackendChoice& b) {
    return a.entry == b.entry && a.parameters.values() == b.parameters.values();
  }
};

/// Who detects contacts with what, where that is not left to the case's backend.
struct ColliderBackends {
  std::vector<std::optional<BackendChoice>> of_bones = {};  ///< one a bone, nothing: the case's; empty: that for all
  std::vector<const BackendEntry*> of_pairs = {};           ///< one for each of the scene's muscle pairs
};

/// For each bone and each pair of muscles what the options say (`--for`: texts COLLIDER=BACKEND or, of a bone,
/// COLLIDER=BACKEND:key=value,key=value, where a collider is a bone, or `muscles`), else the scene; between muscles at
/// last the first exact backend that can follow a surface which deforms. A backend named without parameters has its
/// defaults, or the case's where it is the case's. Throws InputError for a name or parameter that is none, and for a
/// backend that can't do it.
ColliderBackends choose_collider_backends(const std::vector<std::string>& options, const Scene& scene,
                                          const BackendEntry& backend);

/// The same of bones alone, for commands that ask backends about positions which are given: between muscles nothing is
/// detected there.
ColliderBackends bone_backends(const std::vector<std::string>& options, const Scene& scene,
                               const BackendEntry& backend);

/// The unbuilt backend of a case: one for all bones, or several of which each answers for some.
std::unique_ptr<CollisionBackend> make_backend(const BackendEntry& backend, const Parameters& parameters,
                                               const ColliderBackends& colliders);

/// Of bone `bone`: its own, or that of the case.
BackendChoice backend_of_bone(std::size_t bone, const BackendEntry& backend, const Parameters& parameters,
                              const ColliderBackends& colliders);

/// What sees to the scene's muscle pairs: a detector for each backend that is asked for.
std::vector<std::unique_ptr<MuscleContactDetector>> make_muscle_detectors(const Scene& scene,
                                                                          const ColliderBackends& colliders,
                                                                          int threads);

}  // namespace musclebench
