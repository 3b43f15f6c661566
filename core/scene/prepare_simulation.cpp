#include "core/scene/prepare_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/base/random_numbers.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/scene/muscle_contact.hpp"

namespace musclebench {

namespace {

std::vector<int> all_nodes(const Scene& scene) {
  std::vector<int> nodes(scene.muscle_mesh.vertices.size());
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
  backend.update(rest_poses, scene.muscle_mesh.vertices);
  backend.detect(scene.muscle_mesh.vertices, all_nodes(scene), contacts);
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

struct NamedEffect {
  const EffectEntry* entry;
  const Parameters* parameters;
};

std::vector<NamedEffect> named_effects(const Scene& scene) {
  std::vector<NamedEffect> named;
  for (const SceneEffect& effect : scene.effects) named.push_back({find_effect(effect.name), &effect.parameters});
  return named;
}

/// The same on every machine.
void add_noise(double most_m, Particles& particles) {
  RandomNumbers random(1);
  for (std::size_t node = 0; node < particles.size(); ++node) {
    for (double& coordinate : particles.positions[node]) {
      const double noise_m = most_m * (2 * random.share() - 1);
      if (particles.inverse_masses[node] > 0) coordinate += noise_m;
    }
  }
}

Particles particles_of(const Scene& scene, const std::vector<BoundNode>& bound) {
  Particles particles;
  particles.positions = scene.muscle_mesh.vertices;
  particles.velocities.assign(particles.size(), Vec3::Zero());
  for (const Muscle& muscle : scene.muscles) {
    particles.inverse_masses.resize(static_cast<std::size_t>(muscle.body.last_node), 1 / node_mass_kg(scene, muscle));
    std::fill(particles.velocities.begin() + muscle.body.first_node,
              particles.velocities.begin() + muscle.body.last_node, muscle.velocity_m_per_s);
  }
  for (const BoundNode& node : bound) {
    particles.inverse_masses[node.node] = 0;
  }
  if (scene.loop.start_noise_m > 0) add_noise(scene.loop.start_noise_m, particles);
  return particles;
}

}  // namespace

PreparedSimulation prepare_simulation(const Scene& scene, CollisionBackend& backend,
                                      const std::vector<ResponseKind>& responses, int threads, ContactMethods methods) {
  if (!scene.muscle_pairs.empty() && methods.muscle_detectors.empty()) {
    throw std::invalid_argument("prepare_simulation: the scene's muscles touch, and there is no detector for that");
  }
  const std::vector<RigidMotion> rest_poses(scene.bones.size());
  PreparedSimulation prepared;
  prepared.bound_nodes = bind_nodes(scene, backend, rest_poses);
  std::vector<std::unique_ptr<Effect>> effects;
  const std::vector<Body> bodies = scene.bodies();
  const std::vector<std::vector<FibreSegment>> fibres = scene.fibres_with(prepared.bound_nodes);
  NodeOrder order(scene.muscle_mesh.vertices, bodies);
  std::vector<EndNodes> ends;
  for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
    ends.push_back(scene.end_nodes(muscle, prepared.bound_nodes));
  }
  const EffectInput input{scene.muscle_mesh,    bodies,     order, fibres,
                          prepared.bound_nodes, rest_poses, ends,  scene.retinacula};
  const std::vector<NamedEffect> named = named_effects(scene);
  for (const auto& [entry, parameters] : named) {
    if (!entry->make) continue;
    effects.push_back(entry->make(input, *parameters));
    prepared.effect_names.push_back(entry->name);
  }
  ContactProperties contacts;
  for (const auto& [entry, parameters] : named) {
    if (entry->set_contacts) entry->set_contacts(contacts, *parameters);
  }
  Response response(scene.responses(responses), bodies);
  response.set_margin(contacts.margin_m);
  for (const auto& [entry, parameters] : named) {
    if (entry->set_response) entry->set_response(response, *parameters);
  }
  const Particles particles = particles_of(scene, prepared.bound_nodes);
  prepared.simulation = std::make_unique<Simulation>(
      scene.loop, particles, std::move(order), std::move(effects), backend, std::move(response),
      [&scene](double position, std::vector<RigidMotion>& poses) { scene.poses_at(position, poses); }, threads);
  if (!methods.muscle_detectors.empty()) {
    prepared.simulation->add_stage(
        make_muscle_contact_stage(scene, particles.inverse_masses, contacts, std::move(methods.muscle_detectors)));
  }
  for (const auto& [entry, parameters] : named) {
    if (!entry->make_stage) continue;
    prepared.simulation->add_stage(
        entry->make_stage({scene.bones, scene.muscle_mesh.vertices.size(), scene.muscle_mesh.triangles,
                           particles.inverse_masses, prepared.bound_nodes, threads, &scene.muscle_mesh, bodies,
                           backend.untouched(), contacts, methods.make_surface_queries},
                          *parameters));
  }
  prepared.simulation->limit_motion(motion_limits(scene));
  for (const auto& stage : prepared.simulation->stages()) {
    prepared.stage_names.emplace_back(stage->name());
  }
  prepared.simulation->settle();
  return prepared;
}

double node_mass_kg(const Scene& scene, const Muscle& muscle) {
  const double volume_m3 =
      std::abs(body_volume_m3(scene.muscle_mesh.vertices, scene.muscle_mesh.triangles, muscle.body));
  const double nodes = muscle.body.last_node - muscle.body.first_node;
  const double shared_mass_kg = muscle.density_kg_per_m3.value_or(scene.loop.density_kg_per_m3) * volume_m3 / nodes;
  return shared_mass_kg > 0 ? shared_mass_kg : scene.loop.node_mass_kg;
}

MotionLimits motion_limits(const Scene& scene) {
  constexpr double range_diagonals = 10;
  constexpr double move_diagonals = 2;  // what is attached to a bone that jumps by half a turn moves less
  const double diagonal_m = scene_diagonal_m(scene);
  return {.range_m = range_diagonals * diagonal_m, .move_m = move_diagonals * diagonal_m};
}

double scene_diagonal_m(const Scene& scene) {
  Eigen::AlignedBox3d box = bounding_box(scene.muscle_mesh.vertices);
  for (const Bone& bone : scene.bones) {
    box.extend(bounding_box(bone.surface.mesh.vertices));
  }
  return box.diagonal().norm();
}

}  // namespace musclebench
