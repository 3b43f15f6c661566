#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/contact/collision_backend.hpp"
#include "core/contact/muscle_contact.hpp"
#include "core/contact/response.hpp"
#include "core/mesh/bound_node.hpp"
#include "core/pbd/simulation.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// A scene that is ready for its first frame.
struct PreparedSimulation {
  std::vector<BoundNode> bound_nodes;
  std::vector<std::string> effect_names;  ///< in the order of the simulation's
  std::vector<std::string> stage_names;   ///< the same of its contact stages
  std::unique_ptr<Simulation> simulation;
};

/// `scene` and `backend`, which is built over the scene's bones, outlive the simulation. `responses`: one for all,
/// or one a muscle and bone. `muscle_detectors` see to all `muscle_pairs` of the scene. Throws std::invalid_argument
/// where there are some and no detector: muscles would pass through each other in silence.
PreparedSimulation prepare_simulation(const Scene& scene, CollisionBackend& backend,
                                      const std::vector<ResponseKind>& responses, int threads,
                                      std::vector<std::unique_ptr<MuscleContactDetector>> muscle_detectors = {});

/// Of each of its nodes.
double node_mass_kg(const Scene& scene, const Muscle& muscle);

/// Of the box around muscle and bones at rest.
double scene_diagonal_m(const Scene& scene);

/// Beyond which a run of the scene has diverged.
MotionLimits motion_limits(const Scene& scene);

}  // namespace musclebench
