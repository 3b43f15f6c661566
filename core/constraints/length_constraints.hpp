#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/constraints/constraint_lanes.hpp"

namespace musclebench {

/// C = |x_j - x_i| - L0.
struct LengthConstraint {
  std::array<int, 2> nodes;
  double rest_length_m;
  double stiffness;           ///< part of the error that a projection corrects
  double compliance_m_per_n;  ///< XPBD (Macklin et al. 2016); 0: none
};

/// Distances between nodes (Mueller et al. 2007), projected in SIMD lanes. Nodes at the same position have no direction
/// and are skipped.
class LengthConstraints {
 public:
  /// In each projection the constraints are gone through `visits` times.
  LengthConstraints(std::span<const LengthConstraint> constraints, const NodeOrder& order, int visits = 1);

  // Every thread of the team makes these calls, and waits for the others between them.
  void begin_substep(const Team& team);
  /// From now on; `length_of(i)`: of the i-th constraint, m.
  template <typename LengthOf>
  void set_rest_lengths(const Team& team, const LengthOf& length_of) {
    const std::span<const int> slots = m_order.slots();
    const Team::Share share = team.share(slots.size());
    for (std::size_t slot = share.first; slot < share.last; ++slot) {
      if (slots[slot] >= 0) m_rest_length_m[slot] = length_of(static_cast<std::size_t>(slots[slot]));
    }
  }
  void project(NodeRows& rows, double time_step_s, const Team& team);

 private:
  ConstraintOrder<2> m_order;
  std::vector<double> m_rest_length_m, m_stiffness;
  std::vector<double> m_compliance_m_per_n;  ///< empty, as `m_multipliers`, where no constraint is compliant
  std::vector<double> m_multipliers;         ///< Lagrange multipliers (XPBD) of the substep
  bool m_has_multipliers = false;
  int m_visits;
};

}  // namespace musclebench
