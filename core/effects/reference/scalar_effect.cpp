#include "core/effects/reference/scalar_effect.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/portable_math.hpp"
#include "core/effects/reference/scalar_local_volume.hpp"
#include "core/effects/surface_edges.hpp"
#include "core/fibres/fibre_alignment.hpp"

namespace musclebench {

namespace {

class ScalarAttachment final : public ScalarEffect {
 public:
  explicit ScalarAttachment(const EffectInput& input) : m_bound_nodes(input.bound_nodes) {
    for (const BoundNode& bound : m_bound_nodes) {
      m_bone_frame_positions.push_back(input.rest_poses[bound.bone].apply_inverse(input.mesh.vertices[bound.node]));
    }
  }

  void project(std::vector<Vec3>& predicted, const std::vector<double>& /*inverse_masses*/,
               const SubstepInput& input) override {
    for (std::size_t i = 0; i < m_bound_nodes.size(); ++i) {
      predicted[m_bound_nodes[i].node] = input.bone_poses[m_bound_nodes[i].bone].apply(m_bone_frame_positions[i]);
    }
  }

 private:
  std::vector<BoundNode> m_bound_nodes;
  std::vector<Vec3> m_bone_frame_positions;
};

class ScalarEdgeLength final : public ScalarEffect {
 public:
  ScalarEdgeLength(const EffectInput& input, const Parameters& parameters)
      : m_visits(static_cast<int>(parameters.integer("visits_per_edge"))) {
    const double stiffness = parameters.number("stiffness");
    const double compliance = parameters.number("compliance_m_per_n");
    const double exponent = parameters.number("anisotropy_exponent");
    for (const SurfaceEdge& edge : surface_edges(input.mesh)) {
      const Vec3& start = input.mesh.vertices[edge.start];
      const Vec3& end = input.mesh.vertices[edge.end];
      const std::vector<FibreSegment>& fibres = input.fibres[body_of(input.bodies, edge.start)];
      const double alignment = alignment_with_nearest_fibre(fibres, 0.5 * (start + end), end - start);
      const double across = fibres.empty() ? 1 : portable::pow(1 - alignment, exponent);
      if (stiffness * across > 0) {
        m_constraints.push_back({edge.start, edge.end, (end - start).norm(),
                                 compliance > 0 ? stiffness : stiffness * across, compliance / across});
      }
    }
    m_multipliers.resize(m_constraints.size());
  }

  void begin_substep() override { std::fill(m_multipliers.begin(), m_multipliers.end(), 0); }

  void project(std::vector<Vec3>& predicted, const std::vector<double>& inverse_masses,
               const SubstepInput& input) override {
    const double per_time_step2 = 1 / (input.time_step_s * input.time_step_s);
    for (int visit = 0; visit < m_visits; ++visit) {
      for (std::size_t i = 0; i < m_constraints.size(); ++i) {
        project(m_constraints[i], m_constraints[i].compliance_m_per_n * per_time_step2, m_multipliers[i],
                predicted.data(), inverse_masses.data());
      }
    }
  }

 private:
  struct Constraint {
    int start;
    int end;
    double rest_length_m;
    double stiffness;
    double compliance_m_per_n;
  };

  static void project(const Constraint& constraint, double compliance, double& multiplier, Vec3* predicted,
                      const double* inverse_masses) {
    Vec3& start = predicted[constraint.start];
    Vec3& end = predicted[constraint.end];
    const double start_weight = inverse_masses[constraint.start];
    const double end_weight = inverse_masses[constraint.end];
    const Vec3 along = end - start;
    const double length_m = along.norm();
    const double weights = start_weight + end_weight;
    if (!(length_m * weights > 0)) {
      return;
    }
    const double change =
        constraint.stiffness * (length_m - constraint.rest_length_m - compliance * multiplier) / (weights + compliance);
    multiplier += change;
    const Vec3 correction = (change / length_m) * along;
    start += start_weight * correction;
    end -= end_weight * correction;
  }

  std::vector<Constraint> m_constraints;
  std::vector<double> m_multipliers;
  int m_visits;
};

/// sin and cos of the signed dihedral angle (0 when flat), scaled by a common positive factor.
struct Dihedral {
  Vec3 edge;         ///< end - start
  Vec3 left_normal;  ///< twice the area of the left triangle long
  Vec3 right_normal;
  double edge_length_m;
  double sine;
  double cosine;
};

Dihedral dihedral(const Vec3& start, const Vec3& end, const Vec3& left, const Vec3& right) {
  Dihedral d;
  d.edge = end - start;
  d.left_normal = d.edge.cross(left - start);
  d.right_normal = (right - start).cross(d.edge);
  d.edge_length_m = d.edge.norm();
  d.sine = d.right_normal.cross(d.left_normal).dot(d.edge);
  d.cosine = d.edge_length_m * d.left_normal.dot(d.right_normal);
  return d;
}

class ScalarBending final : public ScalarEffect {
 public:
  ScalarBending(const EffectInput& input, const Parameters& parameters)
      : m_stiffness(parameters.number("stiffness")),
        m_compliance_rad_per_n_m(parameters.number("compliance_rad_per_n_m")),
        m_ratio_gate(parameters.flag("public_code_ratio_gate")) {
    const double flat_cosine = std::cos(parameters.number("skip_flatter_than_rad"));
    const bool skip_flat = parameters.number("skip_flatter_than_rad") > 0;
    const auto& x = input.mesh.vertices;
    for (const SurfaceEdge& edge : surface_edges(input.mesh)) {
      if (edge.left < 0 || edge.right < 0) {
        continue;
      }
      const Dihedral rest = dihedral(x[edge.start], x[edge.end], x[edge.left], x[edge.right]);
      const double scale = std::hypot(rest.sine, rest.cosine);
      if (!(scale > 0) || (skip_flat && rest.cosine / scale > flat_cosine)) {
        continue;
      }
      m_constraints.push_back({edge.start, edge.end, edge.left, edge.right, rest.sine / scale, rest.cosine / scale});
    }
    m_multipliers.resize(m_constraints.size());
  }

  void begin_substep() override { std::fill(m_multipliers.begin(), m_multipliers.end(), 0); }

  void project(std::vector<Vec3>& predicted, const std::vector<double>& inverse_masses,
               const SubstepInput& input) override {
    const double compliance = m_compliance_rad_per_n_m / (input.time_step_s * input.time_step_s);
    for (std::size_t i = 0; i < m_constraints.size(); ++i) {
      project(m_constraints[i], compliance, m_multipliers[i], predicted.data(), inverse_masses.data());
    }
  }

 private:
  struct Constraint {
    int start;
    int end;
    int left;
    int right;
    double rest_sine;
    double rest_cosine;
  };

  void project(const Constraint& constraint, double compliance, double& multiplier, Vec3* predicted,
               const double* inverse_masses) const {
    Vec3& start = predicted[constraint.start];
    Vec3& end = predicted[constraint.end];
    Vec3& left = predicted[constraint.left];
    Vec3& right = predicted[constraint.right];
    const Dihedral now = dihedral(start, end, left, right);
    const double left_norm2 = now.left_normal.squaredNorm();
    const double right_norm2 = now.right_normal.squaredNorm();
    const double least_norm2 = 1e-6 * std::max(left_norm2, right_norm2);
    if (!(left_norm2 > least_norm2) || !(right_norm2 > least_norm2) || !(now.edge_length_m > 0)) {
      return;
    }
    const double error_rad = angle_error(now, constraint);
    if (m_ratio_gate && !passes_ratio_gate(error_rad, constraint)) {
      return;
    }

    const double per_edge = 1 / now.edge_length_m;
    const Vec3 left_per_height = (now.edge_length_m / left_norm2) * now.left_normal;
    const Vec3 right_per_height = (now.edge_length_m / right_norm2) * now.right_normal;
    const double left_part = (left - start).dot(now.edge) * per_edge * per_edge;
    const double right_part = (right - start).dot(now.edge) * per_edge * per_edge;
    const Vec3 end_gradient = left_part * left_per_height + right_part * right_per_height;
    const Vec3 start_gradient = (1 - left_part) * left_per_height + (1 - right_part) * right_per_height;
    const double weighted = inverse_masses[constraint.left] * left_per_height.squaredNorm() +
                            inverse_masses[constraint.right] * right_per_height.squaredNorm() +
                            inverse_masses[constraint.start] * start_gradient.squaredNorm() +
                            inverse_masses[constraint.end] * end_gradient.squaredNorm();
    if (!(weighted > 0)) {
      return;
    }
    const double tip = std::max(inverse_masses[constraint.left], inverse_masses[constraint.right]);
    const bool tips_move = 2 * tip > 0.9 * (inverse_masses[constraint.start] + inverse_masses[constraint.end]);
    const double least = tips_move ? 0
                                   : (0.05 * error_rad * error_rad + 1e-6) *
                                         (inverse_masses[constraint.start] + inverse_masses[constraint.end]) *
                                         (left_per_height.squaredNorm() + right_per_height.squaredNorm());
    const double change =
        m_stiffness * (error_rad - compliance * multiplier) / (std::max(weighted, least) + compliance);
    multiplier += change;
    left -= (change * inverse_masses[constraint.left]) * left_per_height;
    right -= (change * inverse_masses[constraint.right]) * right_per_height;
    start += (change * inverse_masses[constraint.start]) * start_gradient;
    end += (change * inverse_masses[constraint.end]) * end_gradient;
  }

  /// Angle less rest angle, from sine and cosine of the difference, so that it never jumps by 2 pi.
  static double angle_error(const Dihedral& now, const Constraint& rest) {
    return std::atan2(now.sine * rest.rest_cosine - now.cosine * rest.rest_sine,
                      now.cosine * rest.rest_cosine + now.sine * rest.rest_sine);
  }

  static bool passes_ratio_gate(double error_rad, const Constraint& rest) {
    const double rest_angle = std::atan2(rest.rest_sine, rest.rest_cosine);
    return rest_angle != 0 && error_rad * rest_angle >= 0.1 * rest_angle * rest_angle &&
           error_rad * rest_angle <= 10 * rest_angle * rest_angle;
  }

  std::vector<Constraint> m_constraints;
  std::vector<double> m_multipliers;
  double m_stiffness;
  double m_compliance_rad_per_n_m;
  bool m_ratio_gate;
};

class ScalarVolume final : public ScalarEffect {
 public:
  ScalarVolume(const EffectInput& input, const Parameters& parameters)
      : m_bodies(input.bodies),
        m_triangles(input.mesh.triangles),
        m_gradients(input.mesh.vertices.size()),
        m_projection_scale(parameters.number("projection_scale")) {
    for (const Body& body : m_bodies) {
      m_targets_m3.push_back(parameters.number("pressure") * body_volume_m3(input.mesh.vertices, m_triangles, body));
    }
  }

  void project(std::vector<Vec3>& predicted, const std::vector<double>& inverse_masses,
               const SubstepInput& /*input*/) override {
    for (std::size_t i = 0; i < m_bodies.size(); ++i) {
      project(m_bodies[i], m_targets_m3[i], predicted, inverse_masses);
    }
  }

 private:
  void project(const Body& body, double target_m3, std::vector<Vec3>& predicted,
               const std::vector<double>& inverse_masses) {
    const double volume_m3 = accumulate_gradients(body, predicted);
    double weighted = 0;
    for (int i = body.first_node; i < body.last_node; ++i) {
      weighted += inverse_masses[i] * m_gradients[i].squaredNorm();
    }
    if (!(weighted > 0)) {
      return;
    }
    const double multiplier = m_projection_scale * (volume_m3 - target_m3) / weighted;
    for (int i = body.first_node; i < body.last_node; ++i) {
      predicted[i] -= (multiplier * inverse_masses[i]) * m_gradients[i];
    }
  }

  /// Stores dV/dp in m_gradients; returns V.
  double accumulate_gradients(const Body& body, const std::vector<Vec3>& positions) {
    for (int i = body.first_node; i < body.last_node; ++i) m_gradients[i].setZero();
    const Vec3& origin = positions[body.first_node];
    double six_volumes = 0;
    for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
      const Triangle& triangle = m_triangles[t];
      const Vec3 a = positions[triangle[0]] - origin;
      const Vec3 b = positions[triangle[1]] - origin;
      const Vec3 c = positions[triangle[2]] - origin;
      const Vec3 b_cross_c = b.cross(c);
      m_gradients[triangle[0]] += b_cross_c / 6;
      m_gradients[triangle[1]] += c.cross(a) / 6;
      m_gradients[triangle[2]] += a.cross(b) / 6;
      six_volumes += a.dot(b_cross_c);
    }
    return six_volumes / 6;
  }

  std::vector<Body> m_bodies;
  std::vector<Triangle> m_triangles;
  std::vector<Vec3> m_gradients;
  std::vector<double> m_targets_m3;
  double m_projection_scale;
};

}  // namespace

std::unique_ptr<ScalarEffect> make_scalar_effect(std::string_view name, const EffectInput& input,
                                                 const Parameters& parameters) {
  if (name == "attachment") return std::make_unique<ScalarAttachment>(input);
  if (name == "edge_length") return std::make_unique<ScalarEdgeLength>(input, parameters);
  if (name == "bending") return std::make_unique<ScalarBending>(input, parameters);
  if (name == "volume") return std::make_unique<ScalarVolume>(input, parameters);
  if (name == "local_volume") return make_scalar_local_volume(input, parameters);
  return nullptr;
}

}  // namespace musclebench
