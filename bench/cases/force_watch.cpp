#include "bench/cases/force_watch.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

/// Parts of a bone's load: a force and its moment about the origin of the world.
struct Load {
  Vec3 force_n = Vec3::Zero();
  Vec3 moment_n_m = Vec3::Zero();
  double size_n = 0;  ///< sum of the sizes of its parts
  Vec3 at_sum_n_m = Vec3::Zero();

  void add(const Vec3& at, const Vec3& on_bone_n) {
    force_n += on_bone_n;
    moment_n_m += at.cross(on_bone_n);
    size_n += on_bone_n.norm();
    at_sum_n_m += on_bone_n.norm() * at;
  }
  /// The mean of where its parts act, by their sizes.
  [[nodiscard]] Vec3 at_m() const { return size_n > 0 ? Vec3(at_sum_n_m / size_n) : Vec3::Zero(); }
  void add(const Load& other) {
    force_n += other.force_n;
    moment_n_m += other.moment_n_m;
  }
};

/// Of the triangles about a node: a corner of a box has a third of them on each side. A push that looks past all of
/// them would have no area.
constexpr double least_facing = 0.25;

/// Share of all contact that may be of an unknown collider in the row of a joint.
constexpr double most_unknown = 0.001;

double number_or(const SceneEffect& effect, const char* name, double otherwise) {
  const auto found = effect.parameters.values().find(name);
  return found == effect.parameters.values().end() ? otherwise : std::get<double>(found->second);
}

/// A constraint that corrects a part of its error only holds by a force that depends on the number of iterations.
/// A compliance sets the force (Macklin, Mueller and Chentanez 2016).
bool depends_on_iterations(const SceneEffect& effect, bool has_fibres) {
  if (number_or(effect, "compliance_m_per_n", 0) > 0 || number_or(effect, "compliance_rad_per_n_m", 0) > 0)
    return false;
  const bool is_softened = has_fibres && number_or(effect, "anisotropy_exponent", 0) > 0;
  return number_or(effect, "stiffness", 1) < 1 || number_or(effect, "projection_scale", 1) < 1 || is_softened;
}

/// A constraint whose compliance over the squared time step is far below the inverse masses is never reached by few
/// iterations: its force grows with their number. Measured on activated fibres: proportional to it at a ratio of 0.001.
constexpr double least_softness = 0.1;

/// The longest time step with which the effect's edges are soft enough, s; 0 where it asks for none.
double longest_step_s(const Scene& scene, const SceneEffect& effect) {
  const double compliance = number_or(effect, "compliance_m_per_n", 0);
  double longest_s = 0;
  for (const Muscle& muscle : scene.muscles) {
    const double both_per_kg = 2 / node_mass_kg(scene, muscle);
    if (compliance / (scene.loop.time_step_s * scene.loop.time_step_s) < least_softness * both_per_kg) {
      longest_s = std::sqrt(compliance / (least_softness * both_per_kg));
    }
  }
  return longest_s;
}

void add_reason(std::string& reasons, const std::string& reason) { reasons += (reasons.empty() ? "" : "; ") + reason; }

}  // namespace

std::string ForceObstacles::text() const {
  if (contacts == attachments || attachments.empty()) return contacts;
  return contacts.empty() ? fmt::format("of attachments: {}", attachments)
                          : fmt::format("of contacts: {}; of attachments: {}", contacts, attachments);
}

ForceObstacles force_obstacles(const Scene& scene, const std::vector<ResponseKind>& responses) {
  std::string of_all;
  const bool has_density = scene.loop.density_kg_per_m3 > 0 || std::ranges::all_of(scene.muscles, [](const Muscle& m) {
                             return m.density_kg_per_m3.value_or(0) > 0;
                           });
  if (!has_density && scene.loop.node_mass_kg == LoopParameters().node_mass_kg) {
    add_reason(of_all, fmt::format("each node weighs {} kg, as by default (cure: loop.density_kg_per_m3)",
                                   scene.loop.node_mass_kg));
  }
  const bool turns = std::ranges::any_of(scene.motions, &BoneMotion::turns);
  if (turns && !scene.loop.interpolate_poses && scene.loop.substeps > 1) {
    add_reason(of_all, "bones jump in the first substep of a frame (cure: loop.bone_motion = \"interpolated\")");
  }
  ForceObstacles found{of_all, of_all};
  if (std::ranges::find(responses, ResponseKind::backtrack) != responses.end()) {
    add_reason(found.contacts, "the response backtrack moves nodes back along their paths (cure: project)");
  }
  const bool has_fibres = std::ranges::any_of(
      scene.muscles, [](const Muscle& m) { return !m.fibres.empty() || m.fibres_between_attachments; });
  for (const SceneEffect& effect : scene.effects) {
    if (const double step_s = longest_step_s(scene, effect); step_s > 0 && of_all.empty()) {
      add_reason(found.attachments,
                 fmt::format("{} is too stiff for its time step, and its force grows with the number "
                             "of iterations (cure: loop.time_step_s = {:.2g}, with more substeps)",
                             effect.name, step_s));
    }
    if (!depends_on_iterations(effect, has_fibres)) continue;
    add_reason(found.attachments,
               fmt::format("{} corrects a part of its error only, and so depends on the number of "
                           "iterations (cure: {})",
                           effect.name, effect.name.ends_with("volume") ? "projection_scale = 1" : "a compliance"));
  }
  return found;
}

ForceWatch::ForceWatch(const Scene& scene, const std::vector<BoundNode>& bound, const ForceObstacles& obstacles,
                       Simulation& simulation)
    : m_scene(scene), m_obstacles(obstacles), m_bodies(scene.bodies()) {
  carry(bound);
  list_triangles_of_nodes();
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

std::optional<double> ForceWatch::torque_n_m(int bone, const Vec3& moment_n_m, const Vec3& force_n) const {
  const std::optional<Axis>& axis = m_axes[static_cast<std::size_t>(bone)];
  if (!axis) return std::nullopt;
  return axis->direction.dot(moment_n_m - axis->centre_m.cross(force_n));
}

double ForceWatch::area_facing_m2(int node, const Vec3& push_n, std::span<const Vec3> positions) const {
  const auto at = [&](int corner) -> const Vec3& { return positions[static_cast<std::size_t>(corner)]; };
  const Vec3 inward = push_n.stableNormalized();
  double area_m2 = 0;
  double whole_m2 = 0;
  const auto index = static_cast<std::size_t>(node);
  for (std::size_t i = m_first_triangle[index]; i < m_first_triangle[index + 1]; ++i) {
    const auto& [a, b, c] = m_scene.muscle_mesh.triangles[m_triangles[i]];
    const Vec3 sixth_m2 = (at(b) - at(a)).cross(at(c) - at(a)) / 6;
    area_m2 += std::max(0.0, -inward.dot(sixth_m2));
    whole_m2 += sixth_m2.norm();
  }
  return std::max(area_m2, least_facing * whole_m2);
}

void ForceWatch::list_triangles_of_nodes() {
  const std::vector<Triangle>& triangles = m_scene.muscle_mesh.triangles;
  m_first_triangle.assign(m_scene.muscle_mesh.vertices.size() + 1, 0);
  for (const Triangle& triangle : triangles) {
    for (const int node : triangle) ++m_first_triangle[static_cast<std::size_t>(node) + 1];
  }
  std::partial_sum(m_first_triangle.begin(), m_first_triangle.end(), m_first_triangle.begin());
  m_triangles.resize(3 * triangles.size());
  std::vector<std::size_t> next(m_first_triangle.begin(), m_first_triangle.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const int node : triangles[t]) m_triangles[next[static_cast<std::size_t>(node)]++] = t;
  }
}

std::vector<ForceRow> ForceWatch::frame(int number, const Simulation& simulation) const {
  const FrameImpulses& impulses = *simulation.impulses();
  const ContactImpulses& contacts = impulses.by_collider();
  const double per_duration = 1 / impulses.duration_s();
  const std::vector<Vec3>& positions = simulation.positions();
  const double angle_rad = m_scene.angle_rad(number);
  const std::size_t bones = m_scene.bones.size();
  std::vector<Load> of_bones(bones);
  std::vector<ForceRow> rows;
  double unknown_n = 0;
  double told_n = 0;

  const auto add_contact = [&](std::size_t muscle, std::size_t collider) {
    const Body& body = m_bodies[muscle];
    ForceRow row{.frame = number, .angle_rad = angle_rad, .muscle = body.name};
    double normal_n = 0, area_m2 = 0, peak_pa = 0;
    Vec3 friction_n = Vec3::Zero();
    Load on_other;
    for (int node = body.first_node; node < body.last_node; ++node) {
      const Vec3 force_n = per_duration * contacts.at(collider, node);
      if (force_n.isZero(0)) continue;
      const Vec3 push_n = per_duration * contacts.push_at(collider, node);
      row.force_n += force_n;
      friction_n += force_n - push_n;
      on_other.add(positions[static_cast<std::size_t>(node)], -force_n);
      const double area = push_n.isZero(0) ? 0 : area_facing_m2(node, push_n, positions);
      normal_n += push_n.norm();
      area_m2 += area;
      if (area > 0) peak_pa = std::max(peak_pa, push_n.norm() / area);
    }
    row.at_m = on_other.at_m();
    row.normal_n = normal_n;
    row.friction_n = friction_n.norm();
    row.area_m2 = area_m2;
    row.peak_pressure_pa = peak_pa;
    if (collider < bones) {
      row.other = row.bone = m_scene.bones[collider].name;
      row.torque_n_m = torque_n_m(static_cast<int>(collider), on_other.moment_n_m, on_other.force_n);
      of_bones[collider].add(on_other);
    } else if (collider == contacts.unknown()) {
      row.source = ForceSource::unknown;
    } else {
      const bool is_itself = collider == contacts.of_muscle(muscle);
      row.source = is_itself ? ForceSource::itself : ForceSource::muscle;
      row.other = m_bodies[collider - bones].name;
    }
    if (collider == contacts.unknown()) unknown_n += row.force_n.norm();
    told_n += row.force_n.norm();
    // Every bone has its row in every frame; what else there may be only where it is.
    if (collider < bones || !row.force_n.isZero(0) || normal_n > 0) rows.push_back(std::move(row));
  };
  if (m_obstacles.contacts.empty()) {
    for (std::size_t muscle = 0; muscle < m_bodies.size(); ++muscle) {
      for (std::size_t collider = 0; collider < contacts.colliders(); ++collider) add_contact(muscle, collider);
    }
  }

  const auto effects = simulation.effects();
  for (const Carried& carried : m_carried) {
    if (!m_obstacles.attachments.empty()) break;
    Load on_bone;
    Vec3 active_n = Vec3::Zero();
    Vec3 of_effects_n = Vec3::Zero();
    for (const int node : carried.nodes) {
      Vec3 sum_n = Vec3::Zero();
      for (std::size_t effect = 0; effect < effects.size(); ++effect) {
        const Vec3 force_n = per_duration * impulses.of_effect(effect, node);
        sum_n += force_n;
        if (effects[effect]->name() == "activation") active_n += force_n;
      }
      of_effects_n += sum_n;
      for (std::size_t collider = 0; collider < contacts.colliders(); ++collider) {
        sum_n += per_duration * contacts.at(collider, node);
      }
      on_bone.add(positions[static_cast<std::size_t>(node)], sum_n);
    }
    ForceRow row{.frame = number,
                 .angle_rad = angle_rad,
                 .muscle = m_bodies[carried.muscle].name,
                 .source = ForceSource::attachment,
                 .other = carried.name,
                 .bone = m_scene.bones[static_cast<std::size_t>(carried.bone)].name,
                 .force_n = -on_bone.force_n,
                 .at_m = on_bone.at_m()};
    const Vec3 passive_n = of_effects_n - active_n;
    const Vec3 along = (active_n.isZero(0) ? passive_n : active_n).stableNormalized();
    row.active_n = along.dot(active_n);
    row.passive_n = along.dot(passive_n);
    row.torque_n_m = torque_n_m(carried.bone, on_bone.moment_n_m, on_bone.force_n);
    of_bones[static_cast<std::size_t>(carried.bone)].add(on_bone);
    rows.push_back(std::move(row));
  }

  for (std::size_t bone = 0; bone < bones; ++bone) {
    // A joint is not known where contact does not tell its bone.
    if (unknown_n > most_unknown * told_n) break;
    if (!m_axes[bone] || !m_obstacles.contacts.empty() || !m_obstacles.attachments.empty()) continue;
    rows.push_back(
        {.frame = number,
         .angle_rad = angle_rad,
         .muscle = "",
         .source = ForceSource::joint,
         .other = m_scene.bones[bone].name,
         .bone = m_scene.bones[bone].name,
         .force_n = of_bones[bone].force_n,
         .at_m = m_axes[bone]->centre_m,
         .torque_n_m = torque_n_m(static_cast<int>(bone), of_bones[bone].moment_n_m, of_bones[bone].force_n)});
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
      const double area_m2 = push_n.isZero(0) ? 0 : area_facing_m2(node, push_n, positions);
      if (area_m2 > 0) pressure_pa += push_n.norm() / area_m2;
    }
    nodes.forces_n.push_back(per_duration * impulses.of_contacts(node));
    nodes.pressures_pa.push_back(pressure_pa);
  }
  return nodes;
}

}  // namespace musclebench
