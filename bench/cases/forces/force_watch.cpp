#include "bench/cases/forces/force_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "bench/cases/forces/bone_pressure.hpp"

namespace musclebench {

namespace {

/// Of each muscle, the mean force along its fibres over the frame; empty: no effect's fibres pull.
std::vector<double> fibre_forces_n(const Simulation& simulation) {
  for (const auto& effect : simulation.effects()) {
    std::vector<double> forces_n = effect->fibre_impulses_n_s();
    for (double& force_n : forces_n) force_n /= simulation.impulses()->duration_s();
    if (!forces_n.empty()) return forces_n;
  }
  return {};
}

/// Share of all contact that may be of an unknown collider in the row of a joint.
constexpr double most_unknown = 0.001;

}  // namespace

void ForceWatch::Load::add(const Vec3& at_m, const Vec3& part_n) {
  force_n += part_n;
  moment_n_m += at_m.cross(part_n);
  size_n += part_n.norm();
  at_sum_n_m += part_n.norm() * at_m;
}

void ForceWatch::Load::add(const Load& other) {
  force_n += other.force_n;
  moment_n_m += other.moment_n_m;
}

ForceWatch::ForceWatch(const Scene& scene, const std::vector<BoundNode>& bound, const ForceObstacles& obstacles,
                       Simulation& simulation)
    : m_scene(scene),
      m_obstacles(obstacles),
      m_bodies(scene.bodies()),
      m_areas(scene.muscle_mesh.vertices.size(), scene.muscle_mesh.triangles) {
  carry(bound);
  for (const BoneMotion& motion : scene.motions) {
    RigidMotion before;  // of rotations that stand still
    std::optional<Axis> axis;
    for (const BoneRotation& rotation : motion.rotations) {
      if (rotation.turns()) {
        axis = {before.apply(rotation.centre_m), before.apply_to_direction(rotation.axis)};
        break;
      }
      before = before * rotation.pose(0);
    }
    m_axes.push_back(axis);
  }
  simulation.record_impulses(m_bodies);
}

void ForceWatch::carry(const std::vector<BoundNode>& bound) {
  std::set<int> named;
  for (const Attachment& attachment : m_scene.attachments) {
    Carried carried{attachment.name, attachment.muscle, attachment.bone, {}};
    for (const int node : attachment.nodes) {
      // A node in two areas belongs to the first.
      if (named.insert(node).second) carried.nodes.push_back(node);
    }
    m_carried.push_back(std::move(carried));
  }
  for (const BoundNode& node : bound) {
    if (named.contains(node.node)) continue;
    const std::size_t muscle = body_of(m_bodies, node.node);
    auto at = std::ranges::find_if(m_carried, [&](const Carried& c) {
      return c.name == "first_contact" && c.muscle == muscle && c.bone == node.bone;
    });
    if (at == m_carried.end()) at = m_carried.insert(at, {"first_contact", muscle, node.bone, {}});
    at->nodes.push_back(node.node);
  }
}

std::optional<double> ForceWatch::torque_n_m(int bone, const Load& load) const {
  const std::optional<Axis>& axis = m_axes[static_cast<std::size_t>(bone)];
  if (!axis) return std::nullopt;
  return axis->direction.dot(load.moment_n_m - axis->centre_m.cross(load.force_n));
}

ForceWatch::Told ForceWatch::contact(std::size_t muscle, std::size_t collider, const Simulation& simulation) const {
  const FrameImpulses& impulses = *simulation.impulses();
  const ContactImpulses& contacts = impulses.by_collider();
  const double per_duration = 1 / impulses.duration_s();
  const std::vector<Vec3>& positions = simulation.positions();
  const Body& body = m_bodies[muscle];
  Told told{.row = {.muscle = body.name}, .on_other = {}};
  double normal_n = 0, area_m2 = 0, peak_pa = 0;
  Vec3 friction_n = Vec3::Zero();
  for (int node = body.first_node; node < body.last_node; ++node) {
    const Vec3 force_n = per_duration * contacts.at(collider, node);
    if (force_n.isZero(0)) continue;
    const Vec3 push_n = per_duration * contacts.push_at(collider, node);
    friction_n += force_n - push_n;
    told.on_other.add(positions[static_cast<std::size_t>(node)], -force_n);
    const double area = push_n.isZero(0) ? 0 : m_areas.about_m2(node, push_n, positions);
    normal_n += push_n.norm();
    area_m2 += area;
    if (area > 0) peak_pa = std::max(peak_pa, push_n.norm() / area);
  }
  told.row.force_n = -told.on_other.force_n;
  told.row.at_m = told.on_other.at_m();
  told.row.normal_n = normal_n;
  told.row.friction_n = friction_n.norm();
  told.row.area_m2 = area_m2;
  told.row.peak_pressure_pa = peak_pa;
  if (collider < m_scene.bones.size()) {
    told.row.other = told.row.bone = m_scene.bones[collider].name;
    told.row.torque_n_m = torque_n_m(static_cast<int>(collider), told.on_other);
  } else if (collider == contacts.unknown()) {
    told.row.source = ForceSource::unknown;
  } else {
    told.row.source = collider == contacts.of_muscle(muscle) ? ForceSource::itself : ForceSource::muscle;
    told.row.other = m_bodies[collider - m_scene.bones.size()].name;
  }
  return told;
}

ForceWatch::Told ForceWatch::attachment(const Carried& carried, const Simulation& simulation) const {
  const FrameImpulses& impulses = *simulation.impulses();
  const ContactImpulses& contacts = impulses.by_collider();
  const double per_duration = 1 / impulses.duration_s();
  const auto effects = simulation.effects();
  Load on_bone;
  Vec3 active_n = Vec3::Zero();
  Vec3 of_effects_n = Vec3::Zero();
  for (const int node : carried.nodes) {
    Vec3 sum_n = Vec3::Zero();
    for (std::size_t effect = 0; effect < effects.size(); ++effect) {
      const Vec3 force_n = per_duration * impulses.of_effect(effect, node);
      sum_n += force_n;
      if (effects[effect]->name() == "activation" || effects[effect]->name() == "fibre_force") active_n += force_n;
    }
    of_effects_n += sum_n;
    for (std::size_t collider = 0; collider < contacts.colliders(); ++collider) {
      sum_n += per_duration * contacts.at(collider, node);
    }
    on_bone.add(simulation.positions()[static_cast<std::size_t>(node)], sum_n);
  }
  const Vec3 passive_n = of_effects_n - active_n;
  const Vec3 along = (active_n.isZero(0) ? passive_n : active_n).stableNormalized();
  return {.row = {.muscle = m_bodies[carried.muscle].name,
                  .source = ForceSource::attachment,
                  .other = carried.name,
                  .bone = m_scene.bones[static_cast<std::size_t>(carried.bone)].name,
                  .force_n = -on_bone.force_n,
                  .at_m = on_bone.at_m(),
                  .active_n = along.dot(active_n),
                  .passive_n = along.dot(passive_n),
                  .torque_n_m = torque_n_m(carried.bone, on_bone)},
          .on_other = on_bone};
}

std::vector<ForceWatch::Told> ForceWatch::retinacula(const Simulation& simulation) const {
  const auto effects = simulation.effects();
  const auto effect = std::ranges::find(effects, "retinaculum", [](const auto& e) { return e->name(); });
  if (effect == effects.end()) return {};
  const FrameImpulses& impulses = *simulation.impulses();
  const auto index = static_cast<std::size_t>(effect - effects.begin());
  const auto poses = simulation.bone_poses();
  // A node that runs through two of them counts for the one that holds it more.
  const auto share_of_width = [&](const Retinaculum& ring, int node) {
    const Vec3& at = simulation.positions()[static_cast<std::size_t>(node)];
    const RigidMotion& pose = poses[static_cast<std::size_t>(ring.bone)];
    return std::abs(ring.axis.dot(pose.apply_inverse(at) - ring.centre_m)) / ring.half_width_m;
  };
  std::vector<std::size_t> ring_of_node(simulation.positions().size(), m_scene.retinacula.size());
  std::vector<double> shares(simulation.positions().size(), std::numeric_limits<double>::infinity());
  for (std::size_t ring = 0; ring < m_scene.retinacula.size(); ++ring) {
    for (const int node : m_scene.retinacula[ring].nodes) {
      const auto at = static_cast<std::size_t>(node);
      const double share = share_of_width(m_scene.retinacula[ring], node);
      if (share >= shares[at]) continue;
      shares[at] = share;
      ring_of_node[at] = ring;
    }
  }
  std::vector<Told> told;
  for (const Retinaculum& ring : m_scene.retinacula) {
    Load on_bone;
    for (const int node : ring.nodes) {
      if (&m_scene.retinacula[ring_of_node[static_cast<std::size_t>(node)]] != &ring) continue;
      on_bone.add(simulation.positions()[static_cast<std::size_t>(node)],
                  -impulses.of_effect(index, node) / impulses.duration_s());
    }
    told.push_back({.row = {.muscle = m_bodies[ring.muscle].name,
                            .source = ForceSource::retinaculum,
                            .other = ring.name,
                            .bone = m_scene.bones[static_cast<std::size_t>(ring.bone)].name,
                            .force_n = -on_bone.force_n,
                            .at_m = on_bone.at_m(),
                            .torque_n_m = torque_n_m(ring.bone, on_bone)},
                    .on_other = on_bone});
  }
  return told;
}

std::vector<ForceRow> ForceWatch::frame(int number, const Simulation& simulation) const {
  const ContactImpulses& contacts = simulation.impulses()->by_collider();
  const std::size_t bones = m_scene.bones.size();
  const bool tells_contacts = m_obstacles.contacts.empty();
  const bool tells_attachments = m_obstacles.attachments.empty();
  std::vector<Load> of_bones(bones);
  std::vector<ForceRow> rows;
  double unknown_n = 0;
  double told_n = 0;
  for (std::size_t muscle = 0; tells_contacts && muscle < m_bodies.size(); ++muscle) {
    for (std::size_t collider = 0; collider < contacts.colliders(); ++collider) {
      Told told = contact(muscle, collider, simulation);
      if (collider < bones) of_bones[collider].add(told.on_other);
      // By size: what is pushed from two sides at once may add up to nothing.
      (collider == contacts.unknown() ? unknown_n : told_n) += told.on_other.size_n;
      // Every bone has its row in every frame; what else there may be only where it is.
      if (collider < bones || !told.row.force_n.isZero(0) || *told.row.normal_n > 0)
        rows.push_back(std::move(told.row));
    }
  }
  const std::vector<double> fibres_n = fibre_forces_n(simulation);
  for (const Carried& carried : m_carried) {
    if (!tells_attachments) break;
    Told told = attachment(carried, simulation);
    if (!fibres_n.empty()) told.row.fibres_n = fibres_n[carried.muscle];
    of_bones[static_cast<std::size_t>(carried.bone)].add(told.on_other);
    rows.push_back(std::move(told.row));
  }
  const std::vector<Told> rings = tells_contacts && tells_attachments ? retinacula(simulation) : std::vector<Told>();
  for (std::size_t i = 0; i < rings.size(); ++i) {
    of_bones[static_cast<std::size_t>(m_scene.retinacula[i].bone)].add(rings[i].on_other);
    rows.push_back(rings[i].row);
  }
  // A joint is not known where contact does not tell its bone.
  const bool tells_joints = tells_contacts && tells_attachments && unknown_n <= most_unknown * (unknown_n + told_n);
  for (std::size_t bone = 0; tells_joints && bone < bones; ++bone) {
    if (!m_axes[bone]) continue;
    rows.push_back({.muscle = "",
                    .source = ForceSource::joint,
                    .other = m_scene.bones[bone].name,
                    .bone = m_scene.bones[bone].name,
                    .force_n = of_bones[bone].force_n,
                    .at_m = m_axes[bone]->centre_m,
                    .torque_n_m = torque_n_m(static_cast<int>(bone), of_bones[bone])});
  }
  for (ForceRow& row : rows) {
    row.frame = number;
    row.angle_rad = m_scene.angle_rad(number);
  }
  return rows;
}

NodeForces ForceWatch::at_nodes(const Simulation& simulation) const {
  NodeForces nodes;
  if (!m_obstacles.contacts.empty()) return nodes;
  const FrameImpulses& impulses = *simulation.impulses();
  const ContactImpulses& contacts = impulses.by_collider();
  // Before the first frame there is none.
  const double per_duration = impulses.duration_s() > 0 ? 1 / impulses.duration_s() : 0;
  const std::vector<Vec3>& positions = simulation.positions();
  for (int node = 0; node < static_cast<int>(positions.size()); ++node) {
    double pressure_pa = 0;  // of all colliders: what pinches a node adds up
    for (std::size_t collider = 0; collider < contacts.colliders(); ++collider) {
      const Vec3 push_n = per_duration * contacts.push_at(collider, node);
      const double area_m2 = push_n.isZero(0) ? 0 : m_areas.about_m2(node, push_n, positions);
      if (area_m2 > 0) pressure_pa += push_n.norm() / area_m2;
    }
    nodes.forces_n.push_back(per_duration * impulses.of_contacts(node));
    nodes.pressures_pa.push_back(pressure_pa);
  }
  return nodes;
}

std::vector<BoneVertexRow> ForceWatch::on_bones(const Simulation& simulation) const {
  if (!m_obstacles.contacts.empty()) return {};
  const FrameImpulses& impulses = *simulation.impulses();
  const double per_duration = impulses.duration_s() > 0 ? 1 / impulses.duration_s() : 0;
  const std::span<const Triangle> triangles = m_scene.muscle_mesh.triangles;
  std::vector<BoneVertexRow> rows;
  for (std::size_t bone = 0; bone < m_scene.bones.size(); ++bone) {
    const RigidMotion& pose = simulation.bone_poses()[bone];
    std::vector<Vec3> positions_m;
    std::vector<Vec3> pushes_n;
    for (std::size_t node = 0; node < simulation.positions().size(); ++node) {
      const Vec3 push_n = per_duration * impulses.by_collider().push_at(bone, static_cast<int>(node));
      positions_m.push_back(pose.apply_inverse(simulation.positions()[node]));
      pushes_n.emplace_back(pose.rotation.transpose() * push_n);
    }
    if (std::ranges::all_of(pushes_n, [](const Vec3& push_n) { return push_n.isZero(0); })) continue;
    BonePressure pressure(m_scene.bones[bone].surface.mesh);
    // Muscle by muscle: what pinches a thin bone adds up.
    for (const Body& body : m_bodies) {
      pressure.add(triangles.subspan(body.first_triangle, body.last_triangle - body.first_triangle), positions_m,
                   pushes_n);
    }
    const auto& [forces_n, pressures_pa] = pressure.loads();
    for (std::size_t vertex = 0; vertex < forces_n.size(); ++vertex) {
      if (!(pressures_pa[vertex] > 0)) continue;
      rows.push_back({.bone = m_scene.bones[bone].name,
                      .vertex = static_cast<int>(vertex),
                      .pressure_pa = pressures_pa[vertex],
                      .force_n = pose.apply_to_direction(forces_n[vertex])});
    }
  }
  return rows;
}

}  // namespace musclebench
