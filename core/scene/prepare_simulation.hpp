#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/contact/collision_backend.hpp"
#include "core/contact/muscle_contact.hpp"
#include "core/contact/response.hpp"
#include "core/contact/surface_queries.hpp"
#include "core/mesh/bound_node.hpp"
#include "core/pbd/simulation.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// A simulation of a scene that is ready for its first frame.
struct PreparedSimulation {
  std::vector<BoundNode> bound_nodes;      ///< the attached nodes
  std::vector<std::string> effect_names;   ///< in the order of the simulation's effects
  std::vector<std::string> stage_names;    ///< in the order of its contact stages
  std::unique_ptr<Simulation> simulation;  ///< `settle` has run
};

/// Who answers what the backend of a simulation does not.
struct ContactMethods {
  std::vector<std::unique_ptr<MuscleContactDetector>> muscle_detectors = {};
  MakeSurfaceQueries make_surface_queries = {};  ///< for contact of faces with bones; empty: the exact ones
};

/// Makes the simulation of a scene: particles, effects, contact stages and bone motions.
///
/// `backend` must have been built over the scene's bones. `scene` and `backend` must outlive the simulation.
/// `responses` has one kind for all bones, or one for each muscle and bone (Scene::bone_pair). The detectors of
/// `methods` must cover all `muscle_pairs` of the scene. Throws std::invalid_argument if the scene has such pairs but
/// there is no detector.
PreparedSimulation prepare_simulation(const Scene& scene, CollisionBackend& backend,
                                      const std::vector<ResponseKind>& responses, int threads,
                                      ContactMethods methods = {});

/// The mass of each node of a muscle, from its density or the loop's settings.
double node_mass_kg(const Scene& scene, const Muscle& muscle);

/// The diagonal of the box around all muscles and bones at rest, in metres.
double scene_diagonal_m(const Scene& scene);

/// The limits of motion for a scene. If a node exceeds them, the run has diverged.
MotionLimits motion_limits(const Scene& scene);

}  // namespace musclebench
