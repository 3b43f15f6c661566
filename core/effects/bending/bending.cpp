#include "core/effects/bending/bending.hpp"

#include <array>
#include <cmath>
#include <optional>

#include "core/base/portable_math.hpp"
#include "core/effects/constraint_effect.hpp"
#include "core/effects/fixed_nodes.hpp"
#include "core/effects/surface_edges.hpp"

namespace musclebench {

namespace {

/// Nothing where the triangles have no area.
std::optional<AngleConstraint> angle_at_rest(const std::vector<Vec3>& x, const SurfaceEdge& edge) {
  const Vec3 along = x[edge.end] - x[edge.start];
  const Vec3 left_normal = along.cross(x[edge.left] - x[edge.start]);
  const Vec3 right_normal = (x[edge.right] - x[edge.start]).cross(along);
  const double sine = right_normal.cross(left_normal).dot(along);
  const double cosine = along.norm() * left_normal.dot(right_normal);
  const double scale = std::sqrt(sine * sine + cosine * cosine);
  if (!(scale > 0)) return std::nullopt;
  return AngleConstraint{{edge.start, edge.end, edge.left, edge.right}, sine / scale, cosine / scale};
}

std::unique_ptr<Effect> make_bending(const EffectInput& input, const Parameters& parameters) {
  return make_constraint_effect("bending",
                                AngleConstraints(bending_constraints(input, parameters), input.order,
                                                 {.stiffness = parameters.number("stiffness"),
                                                  .compliance_rad_per_n_m = parameters.number("compliance_rad_per_n_m"),
                                                  .has_ratio_gate = parameters.flag("public_code_ratio_gate")}));
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
      per_area_flag("hinge"),
      parameter::flag(
          {.name = "public_code_ratio_gate",
           .default_value = false,
           .help =
               "as the paper's public code: correct only where error over rest angle is 0.1 to 10 (one direction)"}),
      parameter::number({.name = "skip_flatter_than_rad",
                         .unit = "rad",
                         .default_value = 0,
                         .minimum = 0,
                         .maximum = 1.6,
                         .help = "leave out pairs that are flatter than this at rest; 0: none"}),
  };
}

/// Of soft tissue: derived in the preset `standard`.
std::map<std::string, ParameterValue> tissue_bending() { return {{"stiffness", 1.0}, {"compliance_rad_per_n_m", 1e4}}; }

}  // namespace

std::vector<AngleConstraint> bending_constraints(const EffectInput& input, const Parameters& parameters) {
  const double skipped_rad = parameters.number("skip_flatter_than_rad");
  const bool is_per_area = parameters.flag("per_area");
  const FixedNodes fixed(input);
  std::vector<AngleConstraint> constraints;
  for (const SurfaceEdge& edge : surface_edges(input.mesh)) {
    if (edge.left < 0 || edge.right < 0) continue;
    if (fixed.are_all(std::array{edge.start, edge.end, edge.left, edge.right})) continue;
    std::optional<AngleConstraint> angle = angle_at_rest(input.mesh.vertices, edge);
    if (!angle || (skipped_rad > 0 && angle->rest_cosine > portable::cos(skipped_rad))) continue;
    if (is_per_area) angle->compliance_share = relative_area(input.mesh, edge);
    constraints.push_back(*angle);
  }
  return constraints;
}

EffectEntry bending_entry() {
  return {.name = "bending",
          .help = "neighbouring triangles keep their dihedral angle (local shape)",
          .parameters = bending_parameters(),
          .make = make_bending,
          .remedies = {{Requirement::self_passage, tissue_bending()}, {Requirement::returned_shape, tissue_bending()}},
          .inert_at_zero = {"stiffness"},
          .colour = "#6A8CAF"};
}

}  // namespace musclebench
