#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/constraints/constraint_lanes.hpp"

namespace musclebench {

/// C = angle - rest angle, signed, in (-pi, pi], between the triangles on both sides of an edge; 0 when flat.
struct AngleConstraint {
  std::array<int, 4> nodes;  ///< start and end of the edge, third corner on its left and on its right
  double rest_sine;
  double rest_cosine;
  double compliance_share = 1;  ///< multiplies the compliance of the settings
};

struct AngleSettings {
  double stiffness;               ///< part of the error that a projection corrects
  double compliance_rad_per_n_m;  ///< XPBD (Macklin et al. 2016); 0: none
  /// As the paper's public code: an error is corrected only where it is 0.1 to 10 times the rest angle.
  bool has_ratio_gate = false;
};

/// Dihedral angles, projected in SIMD lanes. The gradients use the triangles' heights (Bridson et al. 2003; Tamstorf
/// and Grinspun 2013), which are regular for flat and for folded pairs; pairs with a degenerate triangle are skipped.
///
/// Where only nodes of the edge can move, or tips are much heavier, the edge's gradients cancel as the triangles fold
/// onto each other, and the step of XPBD grows without bound. So the sum that divides it, S = sum_i w_i |grad_i C|^2,
/// counts there as at least (w_start + w_end) (1 / h_left^2 + 1 / h_right^2) (0.05 C^2 + 1e-6), h the heights over the
/// edge: no node is moved by more than sqrt(20) of its triangles' smaller height. Elsewhere the lighter tip's part of S
/// bounds a step to 4.7 of the larger height.
class AngleConstraints {
 public:
  AngleConstraints(std::span<const AngleConstraint> constraints, const NodeOrder& order, const AngleSettings& settings);

  // Every thread of the team makes these calls, and waits for the others between them.
  void begin_substep(const Team& team);
  void project(NodeRows& rows, double time_step_s, const Team& team);

 private:
  ConstraintOrder<4> m_order;
  std::vector<double> m_rest_sine, m_rest_cosine;
  std::vector<double> m_compliance_share;  ///< empty where all are 1
  std::vector<double> m_gate, m_least_gate, m_most_gate;
  std::vector<double> m_multipliers;  ///< Lagrange multipliers (XPBD) of the substep; empty without a compliance
  bool m_has_multipliers = false;
  AngleSettings m_settings;
};

}  // namespace musclebench
