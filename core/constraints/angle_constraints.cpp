#include "core/constraints/angle_constraints.hpp"

#include <algorithm>
#include <limits>

#include "core/base/arc_tangent.hpp"

// Highway compiles this file once for every SIMD target; highway.h has to be included after foreach_target.h.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/constraints/angle_constraints.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#include "core/base/arc_tangent-inl.hpp"
#include "core/constraints/node_lanes-inl.hpp"

#ifndef MUSCLEBENCH_ANGLE_CONSTRAINTS_ONCE
#define MUSCLEBENCH_ANGLE_CONSTRAINTS_ONCE
namespace musclebench {

/// By slot of the constraints' order. An error (angle less rest angle) times the rest angle,
/// `gate`, that is not from `least_gate` to `most_gate` is left as it is; without gates these are null.
struct AngleSlots {
  const std::int32_t* start;
  const std::int32_t* end;
  const std::int32_t* left;
  const std::int32_t* right;
  const double* rest_sine;
  const double* rest_cosine;
  const double* compliance_share;  ///< null where all are 1
  const double* gate;
  const double* least_gate;
  const double* most_gate;
  double* multiplier;    ///< null where the constraints are not compliant
  bool has_multipliers;  ///< false in the first projection of a substep: they are 0, whatever is stored
  NodeRow* impulses;     ///< `NodeRows::impulses`
  double stiffness;
  double compliance;  ///< over the squared time step
};

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

void project_angles(AngleSlots slots, std::size_t first, std::size_t last, NodeRow* rows) {
  const Lanes d;
  const Lane one = hn::Set(d, 1);
  Lane compliance = hn::Set(d, slots.compliance);
  const bool is_compliant = slots.multiplier != nullptr;
  for (std::size_t i = first; i < last; i += lane_count) {
    const NodeLanes start = load_nodes(rows, slots.start + i);
    const NodeLanes end = load_nodes(rows, slots.end + i);
    const NodeLanes left = load_nodes(rows, slots.left + i);
    const NodeLanes right = load_nodes(rows, slots.right + i);

    const VecLanes edge = end.at - start.at;
    const VecLanes to_left = left.at - start.at;
    const VecLanes to_right = right.at - start.at;
    const VecLanes left_normal = cross(edge, to_left);
    const VecLanes right_normal = cross(to_right, edge);
    const Lane edge_norm2 = dot(edge, edge);
    const Lane edge_m = hn::Sqrt(edge_norm2);
    const Lane left_norm2 = dot(left_normal, left_normal);
    const Lane right_norm2 = dot(right_normal, right_normal);
    // The angle of a triangle of nearly no height is meaningless and its gradient unbounded.
    const Lane least_norm2 = hn::Mul(hn::Set(d, 1e-6), hn::Max(left_norm2, right_norm2));
    const Lane norms2 = hn::Mul(left_norm2, right_norm2);
    const Lane all_norms2 = hn::Mul(norms2, edge_norm2);
    LaneMask acts = hn::And(hn::And(hn::Gt(left_norm2, least_norm2), hn::Gt(right_norm2, least_norm2)),
                            hn::Gt(all_norms2, hn::Zero(d)));
    // One division for the three reciprocals; 0 makes all gradients 0.
    const Lane reciprocal = hn::IfThenElseZero(acts, hn::Div(one, all_norms2));

    // Angle less rest angle, from sine and cosine of the difference, so that it never jumps by 2 pi.
    // Both are a length too small: cross(right_normal, left_normal) is dot(to_right, left_normal) times the edge.
    const Lane sine = hn::Mul(edge_m, dot(to_right, left_normal));
    const Lane cosine = dot(left_normal, right_normal);
    const Lane rest_sine = hn::LoadU(d, slots.rest_sine + i);
    const Lane rest_cosine = hn::LoadU(d, slots.rest_cosine + i);
    const Lane error_rad = arc_tangent2(d, hn::Sub(hn::Mul(sine, rest_cosine), hn::Mul(cosine, rest_sine)),
                                        hn::Add(hn::Mul(cosine, rest_cosine), hn::Mul(sine, rest_sine)));
    if (slots.gate != nullptr) {
      const Lane gated = hn::Mul(error_rad, hn::LoadU(d, slots.gate + i));
      acts = hn::And(acts, hn::And(hn::Ge(gated, hn::LoadU(d, slots.least_gate + i)),
                                   hn::Le(gated, hn::LoadU(d, slots.most_gate + i))));
    }

    const Lane per_edge_norm2 = hn::Mul(reciprocal, norms2);
    const Lane per_norms2 = hn::Mul(reciprocal, edge_norm2);
    const Lane left_factor = hn::Mul(hn::Mul(edge_m, per_norms2), right_norm2);
    const Lane right_factor = hn::Mul(hn::Mul(edge_m, per_norms2), left_norm2);
    const VecLanes left_per_height = left_factor * left_normal;
    const VecLanes right_per_height = right_factor * right_normal;
    const Lane left_part = hn::Mul(dot(to_left, edge), per_edge_norm2);
    const Lane right_part = hn::Mul(dot(to_right, edge), per_edge_norm2);
    const VecLanes end_gradient = left_part * left_per_height + right_part * right_per_height;
    const VecLanes start_gradient = (left_per_height + right_per_height) - end_gradient;
    const Lane left_per_height2 = hn::Mul(edge_norm2, hn::Mul(per_norms2, right_norm2));
    const Lane right_per_height2 = hn::Mul(edge_norm2, hn::Mul(per_norms2, left_norm2));
    Lane sum = hn::Add(
        hn::Add(hn::Add(hn::Mul(left.inverse_mass, left_per_height2), hn::Mul(right.inverse_mass, right_per_height2)),
                hn::Mul(start.inverse_mass, dot(start_gradient, start_gradient))),
        hn::Mul(end.inverse_mass, dot(end_gradient, end_gradient)));
    const Lane tip = hn::Max(left.inverse_mass, right.inverse_mass);
    const Lane both_of_edge = hn::Add(start.inverse_mass, end.inverse_mass);
    const LaneMask tips_move = hn::Gt(hn::Add(tip, tip), hn::Mul(hn::Set(d, 0.9), both_of_edge));
    if (!hn::AllTrue(d, tips_move)) {
      const Lane least_share = hn::Add(hn::Mul(hn::Set(d, 0.05), hn::Mul(error_rad, error_rad)), hn::Set(d, 1e-6));
      const Lane least_sum = hn::Mul(hn::Mul(least_share, both_of_edge), hn::Add(left_per_height2, right_per_height2));
      sum = hn::IfThenElse(tips_move, sum, hn::Max(sum, least_sum));
      acts = hn::And(acts, hn::Gt(sum, hn::Zero(d)));
    }
    if (slots.compliance_share != nullptr) {
      compliance = hn::Mul(hn::Set(d, slots.compliance), hn::LoadU(d, slots.compliance_share + i));
    }
    const Lane multiplier = slots.has_multipliers ? hn::LoadU(d, slots.multiplier + i) : hn::Zero(d);
    if (hn::AllFalse(d, acts)) {
      if (is_compliant) hn::StoreU(multiplier, d, slots.multiplier + i);
      continue;
    }
    const Lane error = hn::Sub(error_rad, hn::Mul(compliance, multiplier));
    const Lane change =
        hn::IfThenElseZero(acts, hn::Div(hn::Mul(hn::Set(d, slots.stiffness), error), hn::Add(sum, compliance)));
    if (is_compliant) hn::StoreU(hn::Add(multiplier, change), d, slots.multiplier + i);
    const Lane back = hn::Neg(change);
    if (HWY_UNLIKELY(slots.impulses != nullptr)) {
      add_to_nodes(change * start_gradient, slots.impulses, slots.start + i);
      add_to_nodes(change * end_gradient, slots.impulses, slots.end + i);
      add_to_nodes(back * left_per_height, slots.impulses, slots.left + i);
      add_to_nodes(back * right_per_height, slots.impulses, slots.right + i);
    }
    add_to_nodes(hn::Mul(change, start.inverse_mass) * start_gradient, rows, slots.start + i);
    add_to_nodes(hn::Mul(change, end.inverse_mass) * end_gradient, rows, slots.end + i);
    add_to_nodes(hn::Mul(back, left.inverse_mass) * left_per_height, rows, slots.left + i);
    add_to_nodes(hn::Mul(back, right.inverse_mass) * right_per_height, rows, slots.right + i);
  }
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(project_angles);

AngleConstraints::AngleConstraints(std::span<const AngleConstraint> constraints, const NodeOrder& order,
                                   const AngleSettings& settings)
    : m_order(nodes_of<4>(constraints), order),
      m_rest_sine(by_slot(m_order, 0, [&](std::size_t i) { return constraints[i].rest_sine; })),
      m_rest_cosine(by_slot(m_order, 1, [&](std::size_t i) { return constraints[i].rest_cosine; })),
      m_multipliers(settings.compliance_rad_per_n_m > 0 ? m_order.size() : 0),
      m_settings(settings) {
  if (std::ranges::any_of(constraints, [](const auto& constraint) { return constraint.compliance_share != 1; })) {
    m_compliance_share = by_slot(m_order, 1, [&](std::size_t i) { return constraints[i].compliance_share; });
  }
  if (!settings.has_ratio_gate) return;
  for (std::size_t slot = 0; slot < m_order.size(); ++slot) {
    const double angle_rad = arc_tangent2(m_rest_sine[slot], m_rest_cosine[slot]);
    m_gate.push_back(angle_rad);
    // Flat at rest: the ratio is infinite.
    constexpr double infinity = std::numeric_limits<double>::infinity();
    m_least_gate.push_back(angle_rad == 0 ? infinity : 0.1 * angle_rad * angle_rad);
    m_most_gate.push_back(10 * angle_rad * angle_rad);
  }
}

void AngleConstraints::begin_substep(const Team& team) {
  if (team.is_first()) m_has_multipliers = false;
}

void AngleConstraints::project(NodeRows& rows, double time_step_s, const Team& team) {
  const bool is_compliant = !m_multipliers.empty();
  const AngleSlots slots{.start = m_order.row_offsets(0),
                         .end = m_order.row_offsets(1),
                         .left = m_order.row_offsets(2),
                         .right = m_order.row_offsets(3),
                         .rest_sine = m_rest_sine.data(),
                         .rest_cosine = m_rest_cosine.data(),
                         .compliance_share = m_compliance_share.empty() ? nullptr : m_compliance_share.data(),
                         .gate = m_gate.data(),
                         .least_gate = m_least_gate.data(),
                         .most_gate = m_most_gate.data(),
                         .multiplier = is_compliant ? m_multipliers.data() : nullptr,
                         .has_multipliers = is_compliant && m_has_multipliers,
                         .impulses = rows.impulses(),
                         .stiffness = m_settings.stiffness,
                         .compliance = m_settings.compliance_rad_per_n_m / (time_step_s * time_step_s)};
  m_order.for_each(team, [&](std::size_t first, std::size_t last) {
    HWY_DYNAMIC_DISPATCH(project_angles)(slots, first, last, rows.data());
  });
  if (team.is_first()) m_has_multipliers = true;
}

}  // namespace musclebench
#endif  // HWY_ONCE
