#pragma once

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// A muscle with what effects are made from.
struct Fixture {
  explicit Fixture(TriangleMesh of, std::vector<FibreSegment> with_fibres = {}, std::vector<BoundNode> with_bound = {})
      : mesh(std::move(of)), fibres(std::move(with_fibres)), bound(std::move(with_bound)) {}

  TriangleMesh mesh;
  std::vector<FibreSegment> fibres;
  std::vector<BoundNode> bound;
  std::vector<RigidMotion> poses = {RigidMotion{}};

  std::unique_ptr<Effect> make(const std::string& name, const std::map<std::string, ParameterValue>& given = {}) {
    const EffectEntry* entry = find_effect(name);
    return entry->make({mesh, fibres, bound, poses}, Parameters(entry->parameters, given, "test"));
  }

  [[nodiscard]] Particles particles() const {
    Particles p;
    p.positions = mesh.vertices;
    p.predicted = mesh.vertices;
    p.velocities.assign(mesh.vertices.size(), Vec3::Zero());
    p.inverse_masses.assign(mesh.vertices.size(), 1.0);
    return p;
  }

  void project(Effect& effect, Particles& p, int times = 1) {
    for (int i = 0; i < times; ++i) {
      effect.project(p, {1e-3, poses});
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
