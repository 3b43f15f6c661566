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
};

class EdgeLength final : public Effect {
 public:
  EdgeLength(const EffectInput& input, const Parameters& parameters)
      : m_passes(static_cast<int>(parameters.integer("visits_per_edge"))) {
    const double stiffness = parameters.number("stiffness");
    const double exponent = parameters.number("anisotropy_exponent");
    for (const SurfaceEdge& edge : surface_edges(input.muscle)) {
      const Vec3& start = input.muscle.vertices[edge.start];
      const Vec3& end = input.muscle.vertices[edge.end];
      const double alignment = alignment_with_nearest_fibre(input.fibres, 0.5 * (start + end), end - start);
      const double softened = input.fibres.empty() ? stiffness : stiffness * std::pow(1 - alignment, exponent);
      if (softened > 0) {
        m_constraints.push_back({edge.start, edge.end, (end - start).norm(), softened});
      }
    }
  }

  [[nodiscard]] std::string_view name() const override { return "edge_length"; }

  void project(Particles& particles, const SubstepInput& /*input*/) override {
    Vec3* const predicted = particles.predicted.data();
    const double* const inverse_masses = particles.inverse_masses.data();
    for (const LengthConstraint& constraint : m_constraints) {
      // The public code of the paper meets every edge from both of its ends.
      for (int pass = 0; pass < m_passes; ++pass) {
        Vec3& start = predicted[constraint.start];
        Vec3& end = predicted[constraint.end];
        const double start_weight = inverse_masses[constraint.start];
        const double end_weight = inverse_masses[constraint.end];
        const Vec3 along = end - start;
        const double length_m = along.norm();
        const double denominator = length_m * (start_weight + end_weight);
        if (!(denominator > 0)) {
          continue;
        }
        const Vec3 correction = (constraint.stiffness * (length_m - constraint.rest_length_m) / denominator) * along;
        start += start_weight * correction;
        end -= end_weight * correction;
      }
    }
  }

 private:
  std::vector<LengthConstraint> m_constraints;
  int m_passes;
};

}  // namespace

std::unique_ptr<Effect> make_edge_length(const EffectInput& input, const Parameters& parameters) {
  return std::make_unique<EdgeLength>(input, parameters);
}

std::vector<ParameterSpec> edge_length_parameters() {
  return {
      {"stiffness", 1.0, "part of the error that one visit corrects, across the fibres", 0, 1, {}},
      {"anisotropy_exponent", 0.5, "stiffness is scaled by (1 - |cos(edge, fibre)|)^exponent; 0: isotropic", 0, 16, {}},
      {"visits_per_edge",
       std::int64_t{1},
       "2 as in the paper's public code, which visits an edge from both ends",
       1,
       2,
       {}}};
}

}  // namespace musclebench
