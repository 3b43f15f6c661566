#include "core/constraints/length_constraints.hpp"

#include <algorithm>

// Highway compiles this file once for every SIMD target; highway.h has to be included after foreach_target.h.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/constraints/length_constraints.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#include "core/constraints/node_lanes-inl.hpp"

#ifndef MUSCLEBENCH_LENGTH_CONSTRAINTS_ONCE
#define MUSCLEBENCH_LENGTH_CONSTRAINTS_ONCE
namespace musclebench {

/// By slot of the constraints' order.
struct LengthSlots {
  const std::int32_t* start;
  const std::int32_t* end;
  const double* rest_length_m;
  const double* stiffness;
  const double* compliance_m_per_n;  ///< null, as `multiplier`, where no constraint is compliant
  double* multiplier;
  bool has_multipliers;  ///< false in the first projection of a substep: they are 0, whatever is stored
  NodeRow* impulses;     ///< `NodeRows::impulses`
};

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

struct SolvedLengths {
  NodeLanes start, end;
  VecLanes correction;  ///< of a node of inverse mass 1
};

HWY_INLINE SolvedLengths solve(const LengthSlots& slots, std::size_t i, double per_time_step2, const NodeRow* rows) {
  const Lanes d;
  const bool is_compliant = slots.multiplier != nullptr;
  const NodeLanes start = load_nodes(rows, slots.start + i);
  const NodeLanes end = load_nodes(rows, slots.end + i);
  const VecLanes along = end.at - start.at;
  const Lane length_m = hn::Sqrt(dot(along, along));
  const Lane weights = hn::Add(start.inverse_mass, end.inverse_mass);
  const LaneMask acts = hn::Gt(hn::Mul(length_m, weights), hn::Zero(d));
  const Lane compliance =
      is_compliant ? hn::Mul(hn::LoadU(d, slots.compliance_m_per_n + i), hn::Set(d, per_time_step2)) : hn::Zero(d);
  const Lane multiplier = slots.has_multipliers ? hn::LoadU(d, slots.multiplier + i) : hn::Zero(d);
  const Lane error_m =
      hn::Sub(hn::Sub(length_m, hn::LoadU(d, slots.rest_length_m + i)), hn::Mul(compliance, multiplier));
  // Over the length, which spares a division.
  const Lane change_per_m = hn::IfThenElseZero(acts, hn::Div(hn::Mul(hn::LoadU(d, slots.stiffness + i), error_m),
                                                             hn::Mul(hn::Add(weights, compliance), length_m)));
  if (is_compliant) hn::StoreU(hn::Add(multiplier, hn::Mul(change_per_m, length_m)), d, slots.multiplier + i);
  return {start, end, change_per_m * along};
}

HWY_INLINE void apply(SolvedLengths solved, const LengthSlots& slots, std::size_t i, NodeRow* rows) {
  auto& [start, end, correction] = solved;
  if (HWY_UNLIKELY(slots.impulses != nullptr)) {
    add_to_nodes(correction, slots.impulses, slots.start + i);
    add_to_nodes(hn::Set(Lanes(), -1) * correction, slots.impulses, slots.end + i);
  }
  start.at = start.at + start.inverse_mass * correction;
  end.at = end.at - end.inverse_mass * correction;
  store_nodes(start, rows, slots.start + i);
  store_nodes(end, rows, slots.end + i);
}

/// Two blocks at a time: the out-of-order window of a CPU does not reach the next block while one waits for its
/// quotient. Narrower vectors come with half of the registers, too few for two blocks.
void project_lengths(LengthSlots slots, std::size_t first, std::size_t last, double per_time_step2, NodeRow* rows) {
  std::size_t i = first;
  if constexpr (lane_count == constraint_lanes) {
    for (; i + 2 * lane_count <= last; i += 2 * lane_count) {
      const SolvedLengths one = solve(slots, i, per_time_step2, rows);
      const SolvedLengths two = solve(slots, i + lane_count, per_time_step2, rows);
      apply(one, slots, i, rows);
      apply(two, slots, i + lane_count, rows);
    }
  }
  for (; i < last; i += lane_count) apply(solve(slots, i, per_time_step2, rows), slots, i, rows);
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(project_lengths);

LengthConstraints::LengthConstraints(std::span<const LengthConstraint> constraints, const NodeOrder& order, int visits)
    : m_order(nodes_of<2>(constraints), order),
      m_rest_length_m(by_slot(m_order, 0, [&](std::size_t i) { return constraints[i].rest_length_m; })),
      m_stiffness(by_slot(m_order, 0, [&](std::size_t i) { return constraints[i].stiffness; })),
      m_visits(visits) {
  if (std::ranges::none_of(constraints, [](const auto& constraint) { return constraint.compliance_m_per_n > 0; })) {
    return;
  }
  m_compliance_m_per_n = by_slot(m_order, 0, [&](std::size_t i) { return constraints[i].compliance_m_per_n; });
  m_multipliers.resize(m_order.size());
}

void LengthConstraints::begin_substep(const Team& team) {
  if (team.is_first()) m_has_multipliers = false;
}

void LengthConstraints::project(NodeRows& rows, double time_step_s, const Team& team) {
  const bool is_compliant = !m_multipliers.empty();
  LengthSlots slots{.start = m_order.row_offsets(0),
                    .end = m_order.row_offsets(1),
                    .rest_length_m = m_rest_length_m.data(),
                    .stiffness = m_stiffness.data(),
                    .compliance_m_per_n = is_compliant ? m_compliance_m_per_n.data() : nullptr,
                    .multiplier = is_compliant ? m_multipliers.data() : nullptr,
                    .has_multipliers = is_compliant && m_has_multipliers,
                    .impulses = rows.impulses()};
  const double per_time_step2 = 1 / (time_step_s * time_step_s);
  for (int visit = 0; visit < m_visits; ++visit) {
    m_order.for_each(team, [&](std::size_t first, std::size_t last) {
      HWY_DYNAMIC_DISPATCH(project_lengths)(slots, first, last, per_time_step2, rows.data());
    });
    slots.has_multipliers = is_compliant;
  }
  if (team.is_first()) m_has_multipliers = true;
}

}  // namespace musclebench
#endif  // HWY_ONCE
