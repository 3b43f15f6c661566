#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/registry.hpp"
#include "core/scene/prepare_simulation.hpp"
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
  /// One a muscle and bone (Scene::bone_pair), nothing: the case's; empty: that for all.
  std::vector<std::optional<BackendChoice>> with_bones = {};
  std::vector<BackendChoice> of_muscle_pairs = {};  ///< one for each of the scene's
  std::optional<BackendChoice> of_faces = {};       ///< with bones (surface_contact); nothing: the exact distance
};

/// For each muscle and bone and each pair of muscles what the options say (`--for`: texts COLLIDERS=BACKEND or
/// COLLIDERS=BACKEND:key=value,key=value, where colliders are a bone, MUSCLE/BONE, `muscles`, MUSCLE/MUSCLE or `faces`;
/// the pair before all), else the scene; between muscles at last the first exact backend that can follow a surface
/// which deforms. A backend named without parameters has its defaults, or with bones the case's where it is the case's.
/// Throws InputError for a name or parameter that is none, and for a backend that can't do it.
ColliderBackends choose_collider_backends(const std::vector<std::string>& options, const Scene& scene,
                                          const BackendEntry& backend);

/// The unbuilt backend of a case: one for all, or several of which each answers for some muscles and bones. A structure
/// over a bone is built once for each backend that is asked about it.
std::unique_ptr<CollisionBackend> make_backend(const Scene& scene, const BackendEntry& backend,
                                               const Parameters& parameters, const ColliderBackends& colliders);

/// Of a muscle and a bone (Scene::bone_pair): its own, or that of the case.
BackendChoice backend_of_pair(std::size_t pair, const BackendEntry& backend, const Parameters& parameters,
                              const ColliderBackends& colliders);

/// What sees to the scene's muscle pairs: a detector for each backend that is asked for.
std::vector<std::unique_ptr<MuscleContactDetector>> make_muscle_detectors(const Scene& scene,
                                                                          const ColliderBackends& colliders,
                                                                          int threads);

/// What `prepare_simulation` takes for these choices.
ContactMethods make_contact_methods(const Scene& scene, const ColliderBackends& colliders, int threads);

}  // namespace musclebench
