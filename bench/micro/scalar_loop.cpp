#include "bench/micro/scalar_loop.hpp"

#include <cmath>

namespace musclebench {

ScalarLoop::ScalarLoop(const Scene& scene, CollisionBackend& backend, ResponseKind response)
    : m_scene(scene), m_backend(backend), m_response(response) {
  const PreparedSimulation prepared = prepare_simulation(scene, backend, {response}, 1);
  m_positions = prepared.simulation->positions();
  m_predicted = m_positions;
  m_velocities = prepared.simulation->velocities();
  m_free_nodes.assign(prepared.simulation->free_nodes().begin(), prepared.simulation->free_nodes().end());
  const std::vector<Body> bodies = scene.bodies();
  m_inverse_masses.assign(m_positions.size(), 0);
  for (const int node : m_free_nodes) {
    m_inverse_masses[node] = 1 / node_mass_kg(scene, scene.muscles[body_of(bodies, node)]);
  }
  const std::vector<RigidMotion> rest_poses(scene.bones.size());
  const std::vector<std::vector<FibreSegment>> fibres = scene.fibres_with(prepared.bound_nodes);
  const NodeOrder order(scene.muscle_mesh.vertices, bodies);
  for (const SceneEffect& effect : scene.effects) {
    if (effect.name == "damping") m_damping_per_s = effect.parameters.number("rate_per_s");
    auto made = make_scalar_effect(
        effect.name, {scene.muscle_mesh, bodies, order, fibres, prepared.bound_nodes, rest_poses}, effect.parameters);
    if (made != nullptr) m_effects.push_back(std::move(made));
  }
  scene.poses_at(0, m_poses);
  m_previous_poses = m_poses;
}

void ScalarLoop::step_frame(int frame) {
  const LoopParameters& loop = m_scene.loop;
  for (int substep = 1; substep <= loop.substeps; ++substep) {
    m_previous_poses.swap(m_poses);
    const double part = loop.interpolate_poses ? static_cast<double>(substep) / loop.substeps : 1.0;
    m_scene.poses_at(frame - 1 + part, m_poses);
    const double damping = std::exp(-m_damping_per_s * loop.time_step_s);
    for (const int node : m_free_nodes) {
      m_velocities[node] *= damping;
      m_predicted[node] = m_positions[node] + loop.time_step_s * m_velocities[node];
    }
    for (const auto& effect : m_effects) effect->begin_substep();
    for (int iteration = 1; iteration <= loop.iterations; ++iteration) {
      for (const auto& effect : m_effects) effect->project(m_predicted, m_inverse_masses, {loop.time_step_s, m_poses});
      m_backend.update(m_poses, m_predicted);
      m_backend.detect(m_predicted, m_free_nodes, m_contacts);
      m_response.resolve(m_backend, {m_positions, m_previous_poses, m_poses}, m_contacts, m_predicted);
    }
    for (const int node : m_free_nodes) {
      m_velocities[node] = (m_predicted[node] - m_positions[node]) / loop.time_step_s;
    }
    m_positions = m_predicted;
  }
}

}  // namespace musclebench
