#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/constraints/length_constraints.hpp"
#include "core/effects/activation_course.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/effects/surface_edges.hpp"
#include "core/fibres/fibre_alignment.hpp"

namespace musclebench {

namespace {

/// Edges that are more across than along count less than this and are left out.
constexpr double least_alignment = 0.5;

/// Squares of the parts of an edge along its fibre and across it, at rest.
struct EdgeParts {
  double along_m2;
  double across_m2;
  double activation;  ///< the share of its muscle (`Body`)
};

class Activation final : public Effect {
 public:
  Activation(const ActivationCourse& course, double shortening, LengthConstraints constraints,
             std::vector<EdgeParts> parts)
      : m_course(course), m_shortening(shortening), m_constraints(std::move(constraints)), m_parts(std::move(parts)) {}

  [[nodiscard]] std::string_view name() const override { return "activation"; }

  void apply_force(const NodeRows& /*rows*/, std::span<NodeRow> /*velocities*/, const SubstepInput& input,
                   const Team& team) override {
    m_constraints.begin_substep(team);
    const double shortening = shortening_at(input.time_s);
    if (shortening == m_last_shortening) return;
    m_constraints.set_rest_lengths(team, [&](std::size_t i) {
      const double length = 1 - m_parts[i].activation * shortening;
      return std::sqrt(length * length * m_parts[i].along_m2 + m_parts[i].across_m2 / length);
    });
  }

  void project(NodeRows& rows, const SubstepInput& input, const Team& team) override {
    if (team.is_first()) m_last_shortening = shortening_at(input.time_s);  // which all have read
    m_constraints.project(rows, input.time_step_s, team);
  }

 private:
  /// Of a muscle that has all of the activation, as a share of its length at rest.
  [[nodiscard]] double shortening_at(double time_s) const { return m_shortening * m_course.at(time_s); }

  ActivationCourse m_course;
  double m_shortening;
  LengthConstraints m_constraints;
  std::vector<EdgeParts> m_parts;  ///< by constraint
  double m_last_shortening = 0;    ///< that the rest lengths are of
};

std::unique_ptr<Effect> make_activation(const EffectInput& input, const Parameters& parameters) {
  const double compliance = parameters.number("compliance_m_per_n");
  const bool is_per_area = parameters.flag("per_area");
  std::vector<LengthConstraint> constraints;
  std::vector<EdgeParts> parts;
  for (const SurfaceEdge& edge : surface_edges(input.mesh)) {
    const Vec3& start = input.mesh.vertices[edge.start];
    const Vec3& end = input.mesh.vertices[edge.end];
    const std::size_t body = body_of(input.bodies, edge.start);
    const std::vector<FibreSegment>& fibres = input.fibres[body];
    const double alignment = alignment_with_nearest_fibre(fibres, 0.5 * (start + end), end - start);
    if (alignment < least_alignment) continue;
    const double squared_m2 = (end - start).squaredNorm();
    const double along_m2 = alignment * alignment * squared_m2;
    const double share = is_per_area ? alignment * relative_area(input.mesh, edge) : alignment;
    constraints.push_back({{edge.start, edge.end}, std::sqrt(squared_m2), 1, compliance / share});
    parts.push_back({along_m2, std::max(0.0, squared_m2 - along_m2), input.bodies[body].activation});
  }
  return std::make_unique<Activation>(ActivationCourse(parameters), parameters.number("shortening"),
                                      LengthConstraints(constraints, input.order), std::move(parts));
}

std::vector<ParameterSpec> activation_parameters() {
  std::vector<ParameterSpec> parameters = {
      activation_level_parameter(),
      parameter::number({.name = "shortening",
                         .default_value = 0.2,
                         .minimum = 0,
                         .maximum = 0.6,
                         .help = "shortening of free fibres at full activation, as a share of their length"}),
      parameter::number({.name = "compliance_m_per_n",
                         .unit = "m/N",
                         .default_value = 0.005,
                         .minimum = 0,
                         .maximum = 1e6,
                         .help = "compliance of an edge along the fibres (XPBD), larger for other edges; 0: none"}),
      per_area_flag("edge")};
  std::ranges::move(activation_time_parameters(), std::back_inserter(parameters));
  return parameters;
}

}  // namespace

/// A muscle contracts along its fibres by a course over time: from `start_s` the activation rises linearly to `level`
/// within `rise_s`, stays for `hold_s` and falls to 0 within `fall_s`. At activation a the fibres want to be
/// s = 1 - a * `shortening` times as long as at rest.
///
/// Every edge is a distance constraint with a compliance (XPBD), whose rest length is that of the edge in a muscle that
/// has shortened by s along the nearest fibre and become 1 / sqrt(s) times as thick, which keeps its volume; an edge
/// counts by the part of it along the fibre. Contraction by rest lengths along fibres is as in Romeo, Monteagudo,
/// Sanchez-Quiros, Garcia-Fernandez and Urena 2018, "Muscle simulation with extended position based dynamics". Without
/// fibres the effect has nothing to act on.
EffectEntry activation_entry() {
  return {.name = "activation",
          .help = "fibres shorten by a course over time",
          .parameters = activation_parameters(),
          .make = make_activation,
          .inert_at_zero = {"level", "shortening"},
          .colour = "#A9C5DE"};
}

}  // namespace musclebench
