#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/case.hpp"

namespace musclebench {

/// The backend of a case, built over the scene's bones.
struct BuiltBackend {
  std::unique_ptr<CollisionBackend> backend;
  Nanoseconds build_ns = 0;
};

/// `report` is called now and then with the share that is done. Throws InputError when the backend's parameters do not
/// fit the scene.
BuiltBackend build_backend(const Case& resolved, const std::function<void(double share)>& report = {});

/// A scene that is ready for its first frame.
struct PreparedSimulation {
  std::vector<BoundNode> bound_nodes;
  std::vector<std::string> effect_names;  ///< in the order of the simulation's
  std::unique_ptr<Simulation> simulation;
};

/// `resolved.scene` and `backend`, which is built, outlive the simulation.
PreparedSimulation prepare_simulation(const Case& resolved, CollisionBackend& backend);

/// Of the box around muscle and bones at rest.
double scene_diagonal_m(const Scene& scene);

}  // namespace musclebench
