#include "core/effects/edge_length/edge_length.hpp"

#include <array>

#include "core/base/portable_math.hpp"
#include "core/effects/constraint_effect.hpp"
#include "core/effects/fixed_nodes.hpp"
#include "core/effects/surface_edges.hpp"
#include "core/fibres/fibre_alignment.hpp"

namespace musclebench {

namespace {

double across_fibres(const std::vector<FibreSegment>& fibres, const Vec3& start, const Vec3& end, double exponent) {
  const double alignment = alignment_with_nearest_fibre(fibres, 0.5 * (start + end), end - start);
  return portable::pow(1 - alignment, exponent);
}

std::unique_ptr<Effect> make_edge_length(const EffectInput& input, const Parameters& parameters) {
  // The paper's public code iterates over nodes and their edges and so projects every edge twice.
  const auto visits = static_cast<int>(parameters.integer("visits_per_edge"));
  return make_constraint_effect("edge_length",
                                LengthConstraints(edge_length_constraints(input, parameters), input.order, visits));
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
      per_area_flag("edge"),
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

}  // namespace

std::vector<LengthConstraint> edge_length_constraints(const EffectInput& input, const Parameters& parameters) {
  const double stiffness = parameters.number("stiffness");
  const double compliance = parameters.number("compliance_m_per_n");
  const double exponent = parameters.number("anisotropy_exponent");
  const bool is_per_area = parameters.flag("per_area");
  const FixedNodes fixed(input);
  std::vector<LengthConstraint> constraints;
  for (const SurfaceEdge& edge : surface_edges(input.mesh)) {
    if (fixed.are_all(std::array{edge.start, edge.end})) continue;
    const Vec3& start = input.mesh.vertices[edge.start];
    const Vec3& end = input.mesh.vertices[edge.end];
    const std::vector<FibreSegment>& fibres = input.fibres[body_of(input.bodies, edge.start)];
    const double across = fibres.empty() ? 1 : across_fibres(fibres, start, end, exponent);
    const double share = is_per_area ? across * relative_area(input.mesh, edge) : across;
    if (stiffness * across > 0) {
      // A compliant edge is softened by its compliance alone, else it would be softened twice.
      constraints.push_back({{edge.start, edge.end},
                             (end - start).norm(),
                             compliance > 0 ? stiffness : stiffness * across,
                             compliance / share});
    }
  }
  return constraints;
}

EffectEntry edge_length_entry() {
  return {.name = "edge_length",
          .help = "edges keep their rest length, softer along the fibres",
          .parameters = edge_length_parameters(),
          .make = make_edge_length,
          .remedies = {{Requirement::whole_surface}},
          .inert_at_zero = {"stiffness"},
          .colour = "#23395B"};
}

}  // namespace musclebench
