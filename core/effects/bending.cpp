#include "core/effects/bending.hpp"

#include <algorithm>
#include <cmath>

#include "core/effects/surface_edges.hpp"

namespace musclebench {

namespace {

/// sin and cos of the signed dihedral angle (0 when flat), scaled by a common positive factor.
struct Dihedral {
  Vec3 edge;         ///< end - start
  Vec3 left_normal;  ///< twice the area of the left triangle long
  Vec3 right_normal;
  double edge_length_m;
  double sine;
  double cosine;
};

struct BendingConstraint {
  int start;
  int end;
  int left;
  int right;
  double rest_sine;
  double rest_cosine;
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

class Bending final : public Effect {
 public:
  Bending(const EffectInput& input, const Parameters& parameters)
      : m_stiffness(parameters.number("stiffness")),
        m_compliance_rad_per_n_m(parameters.number("compliance_rad_per_n_m")),
        m_ratio_gate(parameters.flag("public_code_ratio_gate")) {
    const double flat_cosine = std::cos(parameters.number("skip_flatter_than_rad"));
    const bool skip_flat = parameters.number("skip_flatter_than_rad") > 0;
    const auto& x = input.muscle.vertices;
    for (const SurfaceEdge& edge : surface_edges(input.muscle)) {
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
  }

  [[nodiscard]] std::string_view name() const override { return "bending"; }

  void apply_force(Particles& /*particles*/, const SubstepInput& /*input*/) override {
    m_multipliers.assign(m_constraints.size(), 0);
  }

  void project(Particles& particles, const SubstepInput& input) override {
    const double compliance = m_compliance_rad_per_n_m / (input.time_step_s * input.time_step_s);
    m_multipliers.resize(m_constraints.size(), 0);
    for (std::size_t i = 0; i < m_constraints.size(); ++i) {
      project(m_constraints[i], compliance, m_multipliers[i], particles.predicted.data(),
              particles.inverse_masses.data());
    }
  }

 private:
  void project(const BendingConstraint& constraint, double compliance, double& multiplier, Vec3* predicted,
               const double* inverse_masses) const {
    Vec3& start = predicted[constraint.start];
    Vec3& end = predicted[constraint.end];
    Vec3& left = predicted[constraint.left];
    Vec3& right = predicted[constraint.right];
    const Dihedral now = dihedral(start, end, left, right);
    const double left_norm2 = now.left_normal.squaredNorm();
    const double right_norm2 = now.right_normal.squaredNorm();
    // The angle of a triangle of nearly no height is meaningless and its gradient unbounded.
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
    const double change = m_stiffness * (error_rad - compliance * multiplier) / (weighted + compliance);
    multiplier += change;
    left -= (change * inverse_masses[constraint.left]) * left_per_height;
    right -= (change * inverse_masses[constraint.right]) * right_per_height;
    start += (change * inverse_masses[constraint.start]) * start_gradient;
    end += (change * inverse_masses[constraint.end]) * end_gradient;
  }

  /// Angle minus rest angle from sine and cosine of the difference, so that it never jumps by 2 pi.
  static double angle_error(const Dihedral& now, const BendingConstraint& rest) {
    return std::atan2(now.sine * rest.rest_cosine - now.cosine * rest.rest_sine,
                      now.cosine * rest.rest_cosine + now.sine * rest.rest_sine);
  }

  static bool passes_ratio_gate(double error_rad, const BendingConstraint& rest) {
    const double rest_angle = std::atan2(rest.rest_sine, rest.rest_cosine);
    // Flat at rest: the ratio is infinite.
    return rest_angle != 0 && error_rad * rest_angle >= 0.1 * rest_angle * rest_angle &&
           error_rad * rest_angle <= 10 * rest_angle * rest_angle;
  }

  std::vector<BendingConstraint> m_constraints;
  std::vector<double> m_multipliers;  ///< Lagrange multipliers (XPBD) of the substep, one a constraint
  double m_stiffness;
  double m_compliance_rad_per_n_m;
  bool m_ratio_gate;
};

}  // namespace

std::unique_ptr<Effect> make_bending(const EffectInput& input, const Parameters& parameters) {
  return std::make_unique<Bending>(input, parameters);
}

std::vector<ParameterSpec> bending_parameters() {
  return {
      parameter::number({.name = "stiffness",
                         .default_value = 0.9,
                         .minimum = 0,
                         .maximum = 1,
                         .help = "part of the error that one visit corrects"}),
      parameter::number({.name = "compliance_rad_per_n_m",
                         .unit = "rad/Nm",
                         .default_value = 0,
                         .minimum = 0,
                         .maximum = 1e12,
                         .help = "compliance of the angle (XPBD); 0: none"}),
      parameter::flag(
          {.name = "public_code_ratio_gate",
           .default_value = false,
           .help =
               "as the paper's public code: correct only where error over rest angle is 0.1 to 10 (one direction)"}),
      parameter::number({.name = "skip_flatter_than_rad",
                         .unit = "rad",
                         .default_value = 0,
                         .minimum = 0,
                         .maximum = 3.2,
                         .help = "leave out pairs that are flatter than this at rest; 0: none"}),
  };
}

}  // namespace musclebench
