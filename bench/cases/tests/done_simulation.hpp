#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/tests/combination_scene.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

/// A simulation that has done `frames` frames, and what its last one left.
struct DoneSimulation {
  Scene scene;
  std::unique_ptr<CollisionBackend> backend;
  PreparedSimulation prepared;
  std::vector<Vec3> velocities_before;  ///< of the last frame
  std::vector<double> masses_kg;        ///< by node; 0: attached

  DoneSimulation(Scene of, bool records, int threads = 1) : scene(std::move(of)) {
    RunCase run = combination_case(scene);
    run.threads = threads;
    backend = build_backend(run, {}).backend;
    prepared = prepare_simulation(scene, *backend, run.responses, threads,
                                  make_contact_methods(scene, run.colliders, threads));
    if (records) prepared.simulation->record_impulses(scene.bodies());
    for (const Muscle& muscle : scene.muscles) {
      masses_kg.resize(static_cast<std::size_t>(muscle.body.last_node), node_mass_kg(scene, muscle));
    }
    for (const BoundNode& bound : prepared.bound_nodes) masses_kg[static_cast<std::size_t>(bound.node)] = 0;
    for (int frame = 1; frame <= scene.loop.frames; ++frame) {
      velocities_before = simulation().velocities();
      simulation().step_frame(frame);
    }
  }
  [[nodiscard]] Simulation& simulation() { return *prepared.simulation; }
  [[nodiscard]] const FrameImpulses& impulses() const { return *prepared.simulation->impulses(); }
  [[nodiscard]] Vec3 of_effects(int node) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < prepared.effect_names.size(); ++i) sum += impulses().of_effect(i, node);
    return sum;
  }
};

}  // namespace musclebench
