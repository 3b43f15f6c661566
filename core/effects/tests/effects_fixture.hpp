#pragma once

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Nodes as tests look at them: in the order of the mesh.
struct Nodes {
  std::vector<Vec3> predicted;
  std::vector<Vec3> velocities;
  std::vector<double> inverse_masses;

  [[nodiscard]] std::size_t size() const { return predicted.size(); }
};

/// A muscle with what effects are made from.
struct Fixture {
  explicit Fixture(TriangleMesh of, std::vector<FibreSegment> with_fibres = {}, std::vector<BoundNode> with_bound = {})
      : mesh(std::move(of)),
        bodies({{"muscle", 0, static_cast<int>(mesh.vertices.size()), 0, mesh.triangles.size()}}),
        order(mesh.vertices, bodies),
        fibres({std::move(with_fibres)}),
        bound(std::move(with_bound)) {}

  TriangleMesh mesh;
  std::vector<Body> bodies;
  NodeOrder order;
  std::vector<std::vector<FibreSegment>> fibres;
  std::vector<BoundNode> bound;
  std::vector<RigidMotion> poses = {RigidMotion{}};
  std::vector<EndNodes> ends = {};

  std::unique_ptr<Effect> make(const std::string& name, const std::map<std::string, ParameterValue>& given = {}) {
    const EffectEntry* entry = find_effect(name);
    return entry->make({mesh, bodies, order, fibres, bound, poses, ends}, Parameters(entry->parameters, given, "test"));
  }

  [[nodiscard]] Nodes particles() const {
    Nodes p;
    p.predicted = mesh.vertices;
    p.velocities.assign(mesh.vertices.size(), Vec3::Zero());
    p.inverse_masses.assign(mesh.vertices.size(), 1.0);
    return p;
  }

  /// As at the start of a substep.
  void apply_force(Effect& effect, Nodes& p, double time_step_s) const {
    const NodeRows rows(order, p.predicted, p.inverse_masses);
    std::vector<NodeRow> velocities(p.size());
    for (std::size_t row = 0; row < p.size(); ++row) {
      velocities[row].set_position(p.velocities[order.node_in(row)]);
    }
    effect.apply_force(rows, velocities, {time_step_s, poses}, Team());
    for (std::size_t row = 0; row < p.size(); ++row) {
      p.velocities[order.node_in(row)] = velocities[row].position();
    }
  }

  void project(Effect& effect, Nodes& p, int times = 1, double time_step_s = 1e-3) {
    NodeRows rows(order, p.predicted, p.inverse_masses);
    for (int i = 0; i < times; ++i) {
      effect.project(rows, {time_step_s, poses}, Team());
    }
    for (std::size_t row = 0; row < p.size(); ++row) {
      p.predicted[order.node_in(row)] = rows[row].position();
    }
  }
};

/// Two triangles that share an edge, folded by the angle about it.
inline TriangleMesh hinge(double angle_rad) {
  return {{{0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}, {0.6, -0.8 * std::cos(angle_rad), 0.8 * std::sin(angle_rad)}},
          {{0, 1, 2}, {1, 0, 3}}};
}

/// Signed angle between the two triangles about their edge; pi or -pi when flat.
inline double hinge_angle(const std::vector<Vec3>& x) {
  const Vec3 e = (x[1] - x[0]).normalized();
  const Vec3 to_left = x[2] - x[0] - e * e.dot(x[2] - x[0]);
  const Vec3 to_right = x[3] - x[0] - e * e.dot(x[3] - x[0]);
  return std::atan2(to_left.cross(to_right).dot(e), to_left.dot(to_right));
}

}  // namespace musclebench
