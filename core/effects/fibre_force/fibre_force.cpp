#include "core/effects/fibre_force/fibre_force.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/constraints/fibre_constraints.hpp"
#include "core/constraints/graph_colours.hpp"
#include "core/effects/activation_course.hpp"
#include "core/effects/fixed_nodes.hpp"
#include "core/effects/surface_edges.hpp"
#include "core/fibres/surface_flow.hpp"
#include "core/mesh/body_mesh.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {

namespace {

/// The fibres of all muscles.
struct Fibres {
  std::vector<FibreConstraint> constraints;
  /// By body, the mean at rest without what bones carry; 0: it has no fibres.
  std::vector<double> free_lengths_m;
};

void add_fibres(const EffectInput& input, std::size_t index, const FixedNodes& fixed, Fibres& fibres) {
  const Body& body = input.bodies[index];
  const TriangleMesh mesh = mesh_of(input.mesh, body);
  const double volume_m3 = surface_volume_m3(mesh.vertices, mesh.triangles);
  const auto is_inner = [](const SurfaceEdge& edge) { return edge.left >= 0 && edge.right >= 0; };
  if (!(volume_m3 > 0) || !std::ranges::all_of(surface_edges(mesh), is_inner)) return;
  const std::vector<Vec3> flow = surface_flow(mesh, input.ends[index]);
  if (flow.empty()) return;
  const std::size_t first = fibres.constraints.size();
  double& free_m = fibres.free_lengths_m[index];
  double length_m = 0;
  for (std::size_t t = 0; t < flow.size(); ++t) {
    const double flow_per_m = flow[t].norm();
    const Triangle& of_all = input.mesh.triangles[body.first_triangle + t];
    if (!(flow_per_m > 0)) continue;
    const std::array<Vec3, 3> gradients = barycentric_gradients(mesh, mesh.triangles[t]);
    const Vec3& a = mesh.vertices[mesh.triangles[t][0]];
    const double area_m2 =
        0.5 * (mesh.vertices[mesh.triangles[t][1]] - a).cross(mesh.vertices[mesh.triangles[t][2]] - a).norm();
    length_m += area_m2 * flow_per_m;
    if (fixed.are_all(of_all)) continue;
    const Vec3 along = flow[t] / flow_per_m;
    FibreConstraint constraint{of_all, {}, area_m2 * flow_per_m};
    for (std::size_t k = 0; k < 3; ++k) constraint.per_m[k] = along.dot(gradients[k]);
    free_m += constraint.volume_m3;
    fibres.constraints.push_back(constraint);
  }
  for (std::size_t i = first; i < fibres.constraints.size(); ++i)
    fibres.constraints[i].volume_m3 *= volume_m3 / length_m;
}

Fibres fibres_of(const EffectInput& input) {
  Fibres fibres;
  fibres.free_lengths_m.assign(input.bodies.size(), 0.0);
  const FixedNodes fixed(input);
  for (std::size_t body = 0; body < input.ends.size(); ++body) add_fibres(input, body, fixed, fibres);
  std::vector<std::array<int, 3>> nodes;
  for (const FibreConstraint& constraint : fibres.constraints) nodes.push_back(constraint.nodes);
  Fibres ordered{{}, fibres.free_lengths_m};
  for (const int i : order_by_colour<3>(nodes, input.mesh.vertices.size())) {
    ordered.constraints.push_back(fibres.constraints[static_cast<std::size_t>(i)]);
  }
  return ordered;
}

class FibreForce final : public Effect {
 public:
  FibreForce(const ActivationCourse& course, Fibres fibres, const EffectInput& input, const FibreLaw& law)
      : m_course(course),
        m_constraints(fibres.constraints, input.bodies, input.order, law),
        m_free_lengths_m(std::move(fibres.free_lengths_m)) {}

  [[nodiscard]] std::string_view name() const override { return "fibre_force"; }

  void apply_force(const NodeRows& rows, std::span<NodeRow> /*velocities*/, const SubstepInput& input,
                   const Team& team) override {
    m_constraints.begin_substep(rows, m_course.at(input.time_s), input.time_step_s, team);
  }

  void project(NodeRows& rows, const SubstepInput& input, const Team& team) override {
    m_constraints.project(rows, input.time_step_s, team);
  }

  void begin_frame() override { m_constraints.forget_pulls(); }

  [[nodiscard]] std::vector<double> fibre_impulses_n_s() const override {
    std::vector<double> impulses = m_constraints.pulls_n_m_s();
    for (std::size_t body = 0; body < impulses.size(); ++body) {
      impulses[body] = m_free_lengths_m[body] > 0 ? impulses[body] / m_free_lengths_m[body] : 0;
    }
    return impulses;
  }

 private:
  ActivationCourse m_course;
  FibreConstraints m_constraints;
  std::vector<double> m_free_lengths_m;  ///< by body
};

FibreLaw law_of(const Parameters& parameters) {
  const double optimal_stretch = parameters.number("optimal_stretch");
  // Muscle keeps its volume: where fibres are longer than at rest its section is as much smaller.
  return {.peak_stress_pa = parameters.number("peak_stress_pa") / optimal_stretch,
          .optimal_stretch = optimal_stretch,
          .passive_strain = parameters.number("passive_strain"),
          .fastest_per_s = parameters.number("fastest_per_s")};
}

std::unique_ptr<Effect> make_fibre_force(const EffectInput& input, const Parameters& parameters) {
  return std::make_unique<FibreForce>(ActivationCourse(parameters), fibres_of(input), input, law_of(parameters));
}

std::vector<ParameterSpec> fibre_force_parameters() {
  const FibreLaw law;
  std::vector<ParameterSpec> parameters = {
      activation_level_parameter(),
      parameter::number({.name = "peak_stress_pa",
                         .unit = "Pa",
                         .default_value = law.peak_stress_pa,
                         .minimum = 0,
                         .maximum = 1e9,
                         .help = "stress of fully active fibres at their optimal length"}),
      parameter::number({.name = "optimal_stretch",
                         .default_value = law.optimal_stretch,
                         .minimum = 0.2,
                         .maximum = 5,
                         .help = "optimal length of the fibres, over their length at rest"}),
      parameter::number({.name = "passive_strain",
                         .default_value = law.passive_strain,
                         .minimum = 0.01,
                         .maximum = 10,
                         .help = "strain beyond the optimal length at which passive fibres bear the peak stress"}),
      parameter::number(
          {.name = "fastest_per_s",
           .unit = "1/s",
           .default_value = law.fastest_per_s,
           .minimum = 0,
           .maximum = 1e6,
           .help = "optimal lengths a second at which active fibres bear nothing; 0: force at any speed"})};
  std::ranges::move(activation_time_parameters(), std::back_inserter(parameters));
  return parameters;
}

}  // namespace

double longest_fibre_step_s(const EffectInput& input, const Parameters& parameters,
                            std::span<const double> inverse_masses) {
  const double stress_pa = parameters.number("level") * law_of(parameters).peak_stress_pa;
  std::vector<double> stiffnesses_n_per_m(inverse_masses.size(), 0.0);
  for (const FibreConstraint& fibre : fibres_of(input).constraints) {
    double sum_per_m = 0;
    for (const double per_m : fibre.per_m) sum_per_m += std::abs(per_m);
    for (std::size_t k = 0; k < 3; ++k) {
      stiffnesses_n_per_m[static_cast<std::size_t>(fibre.nodes[k])] +=
          stress_pa * fibre.volume_m3 * std::abs(fibre.per_m[k]) * sum_per_m;
    }
  }
  double stiffest_per_s2 = 0;
  for (std::size_t node = 0; node < inverse_masses.size(); ++node) {
    stiffest_per_s2 = std::max(stiffest_per_s2, inverse_masses[node] * stiffnesses_n_per_m[node]);
  }
  return stiffest_per_s2 > 0 ? std::sqrt(2 / stiffest_per_s2) : std::numeric_limits<double>::infinity();
}

EffectEntry fibre_force_entry() {
  return {.name = "fibre_force",
          .help = "fibres pull: active, passive and by speed (Hill), and push never",
          .parameters = fibre_force_parameters(),
          .make = make_fibre_force,
          .remedies = {{Requirement::taut_fibres, {{"level", 0.05}}}},
          .inert_at_zero = {"peak_stress_pa"},
          .colour = "#D3E1EE"};
}

}  // namespace musclebench
