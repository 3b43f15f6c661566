#include "core/scene/prepare_simulation.hpp"

#include <algorithm>
#include <cmath>

#include "core/mesh/mesh_size.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {

namespace {

std::vector<int> all_nodes(const Scene& scene) {
  std::vector<int> nodes(scene.muscle.mesh.vertices.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i] = static_cast<int>(i);
  }
  return nodes;
}

std::vector<BoundNode> bind_nodes(const Scene& scene, CollisionBackend& backend,
                                  const std::vector<RigidMotion>& rest_poses) {
  if (!scene.attach_at_first_contact) {
    return scene.bound_nodes();
  }
  std::vector<Contact> contacts;
  backend.update(rest_poses, scene.muscle.mesh.vertices);
  backend.detect(scene.muscle.mesh.vertices, all_nodes(scene), contacts);
  std::vector<BoundNode> bound;
  bound.reserve(contacts.size());
  for (const Contact& contact : contacts) {
    bound.push_back({contact.node, contact.bone});
  }
  std::stable_sort(bound.begin(), bound.end(), [](const BoundNode& a, const BoundNode& b) { return a.node < b.node; });
  bound.erase(
      std::unique(bound.begin(), bound.end(), [](const BoundNode& a, const BoundNode& b) { return a.node == b.node; }),
      bound.end());
  return bound;
}

Particles particles_of(const Scene& scene, const std::vector<BoundNode>& bound) {
  Particles particles;
  particles.positions = scene.muscle.mesh.vertices;
  particles.predicted = particles.positions;
  particles.velocities.assign(particles.size(), Vec3::Zero());
  const double volume_m3 = std::abs(surface_volume_m3(scene.muscle.mesh.vertices, scene.muscle.mesh.triangles));
  const double shared_mass_kg = scene.loop.density_kg_per_m3 * volume_m3 / static_cast<double>(particles.size());
  particles.inverse_masses.assign(particles.size(),
                                  1 / (shared_mass_kg > 0 ? shared_mass_kg : scene.loop.node_mass_kg));
  for (const BoundNode& node : bound) {
    particles.inverse_masses[node.node] = 0;
  }
  return particles;
}

std::vector<int> free_nodes_of(const Particles& particles) {
  std::vector<int> nodes;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (particles.inverse_masses[i] > 0) {
      nodes.push_back(static_cast<int>(i));
    }
  }
  return nodes;
}

}  // namespace

PreparedSimulation prepare_simulation(const Scene& scene, CollisionBackend& backend, ResponseKind response) {
  const std::vector<RigidMotion> rest_poses(scene.bones.size());
  PreparedSimulation prepared;
  prepared.bound_nodes = bind_nodes(scene, backend, rest_poses);
  std::vector<std::unique_ptr<Effect>> effects;
  const std::vector<FibreSegment> fibres = scene.fibres_with(prepared.bound_nodes);
  const EffectInput input{scene.muscle.mesh, fibres, prepared.bound_nodes, rest_poses};
  for (const SceneEffect& effect : scene.effects) {
    effects.push_back(find_effect(effect.name)->make(input, effect.parameters));
    prepared.effect_names.push_back(effect.name);
  }
  Particles particles = particles_of(scene, prepared.bound_nodes);
  std::vector<int> free_nodes = free_nodes_of(particles);
  prepared.simulation = std::make_unique<Simulation>(
      scene.loop, std::move(particles), std::move(free_nodes), std::move(effects), backend, response,
      [&scene](double position, std::vector<RigidMotion>& poses) { scene.poses_at(position, poses); });
  return prepared;
}

double scene_diagonal_m(const Scene& scene) {
  Eigen::AlignedBox3d box = bounding_box(scene.muscle.mesh.vertices);
  for (const Bone& bone : scene.bones) {
    box.extend(bounding_box(bone.surface.mesh.vertices));
  }
  return box.diagonal().norm();
}

}  // namespace musclebench
