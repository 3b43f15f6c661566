#include "core/effects/edge_length.hpp"

#include <cmath>

#include "core/effects/surface_edges.hpp"

namespace musclebench {

namespace {

struct LengthConstraint {
  int start;
  int end;
  double rest_length_m;
  double stiffness;
  double compliance_m_per_n;
};

class EdgeLength final : public Effect {
 public:
  EdgeLength(const EffectInput& input, const Parameters& parameters)
      : m_visits(static_cast<int>(parameters.integer("visits_per_edge"))) {
    const double stiffness = parameters.number("stiffness");
    const double compliance = parameters.number("compliance_m_per_n");
    const double exponent = parameters.number("anisotropy_exponent");
    for (const SurfaceEdge& edge : surface_edges(input.muscle)) {
      const Vec3& start = input.muscle.vertices[edge.start];
      const Vec3& end = input.muscle.vertices[edge.end];
      const double alignment = alignment_with_nearest_fibre(input.fibres, 0.5 * (start + end), end - start);
      const double across = input.fibres.empty() ? 1 : std::pow(1 - alignment, exponent);
      if (stiffness * across > 0) {
        // A compliant edge is softened by its compliance alone, else it would be softened twice.
        m_constraints.push_back({edge.start, edge.end, (end - start).norm(),
                                 compliance > 0 ? stiffness : stiffness * across, compliance / across});
      }
    }
  }

  [[nodiscard]] std::string_view name() const override { return "edge_length"; }

  void apply_force(Particles& /*particles*/, const SubstepInput& /*input*/) override {
    m_multipliers.assign(m_constraints.size(), 0);
  }

  void project(Particles& particles, const SubstepInput& input) override {
    const double per_time_step2 = 1 / (input.time_step_s * input.time_step_s);
    m_multipliers.resize(m_constraints.size(), 0);
    // The paper's public code iterates over nodes and their edges and so projects every edge twice.
    for (int visit = 0; visit < m_visits; ++visit) {
      for (std::size_t i = 0; i < m_constraints.size(); ++i) {
        project(m_constraints[i], m_constraints[i].compliance_m_per_n * per_time_step2, m_multipliers[i],
                particles.predicted.data(), particles.inverse_masses.data());
      }
    }
  }

 private:
  static void project(const LengthConstraint& constraint, double compliance, double& multiplier, Vec3* predicted,
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

  std::vector<LengthConstraint> m_constraints;
  std::vector<double> m_multipliers;  ///< Lagrange multipliers (XPBD) of the substep, one a constraint
  int m_visits;
};

}  // namespace

std::unique_ptr<Effect> make_edge_length(const EffectInput& input, const Parameters& parameters) {
  return std::make_unique<EdgeLength>(input, parameters);
}

std::vector<ParameterSpec> edge_length_parameters() {
  return {
      parameter::number({.name = "stiffness",
                         .default_value = 1,
                         .minimum = 0,
                         .maximum = 1,
                         .help = "part of the error that one visit corrects, across the fibres"}),
      parameter::number(
          {.name = "compliance_m_per_n",
           .unit = "m/N",
           .default_value = 0,
           .minimum = 0,
           .maximum = 1e6,
           .help = "compliance across the fibres (XPBD), divided by the factor of the anisotropy; 0: none"}),
      parameter::number({.name = "anisotropy_exponent",
                         .default_value = 0.5,
                         .minimum = 0,
                         .maximum = 16,
                         .help = "stiffness is scaled by (1 - |cos(edge, fibre)|)^exponent; 0: isotropic"}),
      parameter::integer({.name = "visits_per_edge",
                          .default_value = 1,
                          .minimum = 1,
                          .maximum = 2,
                          .help = "2 as in the paper's public code, which visits an edge from both ends"}),
  };
}

}  // namespace musclebench
