#include "core/effects/edge_length.hpp"

#include <algorithm>

#include "core/base/portable_math.hpp"
#include "core/effects/constraint_lanes.hpp"
#include "core/effects/surface_edges.hpp"

// Highway compiles this file once for every SIMD target; highway.h has to be included after foreach_target.h.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/effects/edge_length.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#include "core/effects/node_lanes-inl.hpp"

#ifndef MUSCLEBENCH_EDGE_LENGTH_ONCE
#define MUSCLEBENCH_EDGE_LENGTH_ONCE
namespace musclebench {

/// Length constraints, a slot of `ConstraintOrder<2>` each.
struct LengthConstraints {
  const std::int32_t* start;
  const std::int32_t* end;
  const double* rest_length_m;
  const double* stiffness;
  const double* compliance_m_per_n;
  double* multiplier;
  bool has_multipliers;  ///< false in the first projection of a substep: they are 0, whatever is stored
};

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

void project_lengths(LengthConstraints constraints, std::size_t first, std::size_t last, double per_time_step2,
                     NodeRow* rows) {
  const Lanes d;
  for (std::size_t i = first; i < last; i += lane_count) {
    NodeLanes start = load_nodes(rows, constraints.start + i);
    NodeLanes end = load_nodes(rows, constraints.end + i);
    const VecLanes along = end.at - start.at;
    const Lane length_m = hn::Sqrt(dot(along, along));
    const Lane weights = hn::Add(start.inverse_mass, end.inverse_mass);
    const LaneMask acts = hn::Gt(hn::Mul(length_m, weights), hn::Zero(d));
    const Lane compliance = hn::Mul(hn::LoadU(d, constraints.compliance_m_per_n + i), hn::Set(d, per_time_step2));
    const Lane multiplier = constraints.has_multipliers ? hn::LoadU(d, constraints.multiplier + i) : hn::Zero(d);
    const Lane error_m =
        hn::Sub(hn::Sub(length_m, hn::LoadU(d, constraints.rest_length_m + i)), hn::Mul(compliance, multiplier));
    // Over the length, which spares a division.
    const Lane change_per_m =
        hn::IfThenElseZero(acts, hn::Div(hn::Mul(hn::LoadU(d, constraints.stiffness + i), error_m),
                                         hn::Mul(hn::Add(weights, compliance), length_m)));
    hn::StoreU(hn::Add(multiplier, hn::Mul(change_per_m, length_m)), d, constraints.multiplier + i);
    const VecLanes correction = change_per_m * along;
    start.at = start.at + start.inverse_mass * correction;
    end.at = end.at - end.inverse_mass * correction;
    store_nodes(start, rows, constraints.start + i);
    store_nodes(end, rows, constraints.end + i);
  }
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(project_lengths);

namespace {

struct LengthConstraint {
  double rest_length_m;
  double stiffness;
  double compliance_m_per_n;
};

class EdgeLength final : public Effect {
 public:
  EdgeLength(std::span<const std::array<int, 2>> ends, std::span<const LengthConstraint> constraints,
             const NodeOrder& order, int visits)
      : m_order(ends, order),
        m_rest_length_m(by_slot(m_order, 0, [&](std::size_t i) { return constraints[i].rest_length_m; })),
        m_stiffness(by_slot(m_order, 0, [&](std::size_t i) { return constraints[i].stiffness; })),
        m_compliance_m_per_n(by_slot(m_order, 0, [&](std::size_t i) { return constraints[i].compliance_m_per_n; })),
        m_multipliers(m_order.size(), 0),
        m_visits(visits) {}

  [[nodiscard]] std::string_view name() const override { return "edge_length"; }

  void apply_force(const NodeRows& /*rows*/, std::span<NodeRow> /*velocities*/, const SubstepInput& /*input*/,
                   const Team& team) override {
    if (team.is_first()) m_has_multipliers = false;
  }

  void project(NodeRows& rows, const SubstepInput& input, const Team& team) override {
    LengthConstraints constraints{.start = m_order.row_offsets(0),
                                  .end = m_order.row_offsets(1),
                                  .rest_length_m = m_rest_length_m.data(),
                                  .stiffness = m_stiffness.data(),
                                  .compliance_m_per_n = m_compliance_m_per_n.data(),
                                  .multiplier = m_multipliers.data(),
                                  .has_multipliers = m_has_multipliers};
    const double per_time_step2 = 1 / (input.time_step_s * input.time_step_s);
    // The paper's public code iterates over nodes and their edges and so projects every edge twice.
    for (int visit = 0; visit < m_visits; ++visit) {
      m_order.for_each(team, [&](std::size_t first, std::size_t last) {
        HWY_DYNAMIC_DISPATCH(project_lengths)(constraints, first, last, per_time_step2, rows.data());
      });
      constraints.has_multipliers = true;
    }
    if (team.is_first()) m_has_multipliers = true;
  }

 private:
  ConstraintOrder<2> m_order;
  std::vector<double> m_rest_length_m, m_stiffness, m_compliance_m_per_n;
  std::vector<double> m_multipliers;  ///< Lagrange multipliers (XPBD) of the substep
  bool m_has_multipliers = false;
  int m_visits;
};

}  // namespace

std::unique_ptr<Effect> make_edge_length(const EffectInput& input, const Parameters& parameters) {
  const double stiffness = parameters.number("stiffness");
  const double compliance = parameters.number("compliance_m_per_n");
  const double exponent = parameters.number("anisotropy_exponent");
  std::vector<std::array<int, 2>> ends;
  std::vector<LengthConstraint> constraints;
  for (const SurfaceEdge& edge : surface_edges(input.mesh)) {
    const Vec3& start = input.mesh.vertices[edge.start];
    const Vec3& end = input.mesh.vertices[edge.end];
    const std::vector<FibreSegment>& fibres = input.fibres[body_of(input.bodies, edge.start)];
    const double alignment = alignment_with_nearest_fibre(fibres, 0.5 * (start + end), end - start);
    const double across = fibres.empty() ? 1 : portable::pow(1 - alignment, exponent);
    if (stiffness * across > 0) {
      ends.push_back({edge.start, edge.end});
      // A compliant edge is softened by its compliance alone, else it would be softened twice.
      constraints.push_back(
          {(end - start).norm(), compliance > 0 ? stiffness : stiffness * across, compliance / across});
    }
  }
  return std::make_unique<EdgeLength>(ends, constraints, input.order,
                                      static_cast<int>(parameters.integer("visits_per_edge")));
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
#endif  // HWY_ONCE
