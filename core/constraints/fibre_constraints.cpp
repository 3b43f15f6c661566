#include "core/constraints/fibre_constraints.hpp"

#include <algorithm>
#include <utility>

#include "core/base/portable_math.hpp"

// Highway compiles this file once for every SIMD target; highway.h has to be included after foreach_target.h.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/constraints/fibre_constraints.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#include "core/constraints/node_lanes-inl.hpp"

#ifndef MUSCLEBENCH_FIBRE_CONSTRAINTS_ONCE
#define MUSCLEBENCH_FIBRE_CONSTRAINTS_ONCE
namespace musclebench {

/// By slot of the constraints' order.
struct FibreSlots {
  std::array<const std::int32_t*, 3> nodes;
  std::array<const double*, 3> per_m;
  const double* volume_m3;
  double* stretch;
  double* pull;
  double* slope;
  double* multiplier;
  double* most;
  double* sum;
  NodeRow* gradients;  ///< null where no fibre is active
  NodeRow* impulses;   ///< `NodeRows::impulses`
};

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

/// e^x for -8 <= x <= 8, relative error below 1e-9: the seventh Taylor polynomial of x / 64, squared six times.
HWY_INLINE Lane exponential(Lane x) {
  const Lanes d;
  constexpr int halvings = 6;
  constexpr int degree = 7;
  const Lane part = hn::Mul(x, hn::Set(d, 1.0 / (1 << halvings)));
  Lane power = hn::Set(d, 1);
  for (int k = degree; k > 0; --k) {
    power = hn::Add(hn::Set(d, 1), hn::Mul(hn::Mul(part, power), hn::Set(d, 1.0 / k)));
  }
  for (int i = 0; i < halvings; ++i) power = hn::Mul(power, power);
  return power;
}

struct Curve {
  Lane value, slope;
};

/// Over length / optimal length.
HWY_INLINE Curve passive_over_length(Lane length, const FibreLaw& law) {
  const Lanes d;
  constexpr double shape = 5;
  constexpr double scale = 1 / (148.4131591025766 - 1);  // e^shape, which the C library gives in several ways
  const double per_strain = shape / law.passive_strain;
  const Lane strain = hn::Sub(length, hn::Set(d, 1));
  const Lane curved = hn::Clamp(strain, hn::Zero(d), hn::Set(d, law.passive_strain));
  const Lane power = hn::Mul(exponential(hn::Mul(curved, hn::Set(d, per_strain))), hn::Set(d, scale));
  const Lane slope = hn::IfThenElseZero(hn::Gt(strain, hn::Zero(d)), hn::Mul(power, hn::Set(d, per_strain)));
  const Lane straight = hn::Max(hn::Sub(strain, curved), hn::Zero(d));
  return {hn::Add(hn::Sub(power, hn::Set(d, scale)), hn::Mul(slope, straight)), slope};
}

template <typename Load>
HWY_INLINE VecLanes fibre_of(const FibreSlots& slots, std::size_t i, const Load& node) {
  const Lanes d;
  const auto part = [&](std::size_t k) { return hn::LoadU(d, slots.per_m[k] + i) * node(k); };
  return part(0) + part(1) + part(2);
}

void begin_fibres(FibreSlots slots, std::size_t first, std::size_t last, const FibreLaw& law, double time_step_s,
                  const NodeRow* rows) {
  const Lanes d;
  const Lane per_optimal = hn::Set(d, 1 / law.optimal_stretch);
  const Lane scale_pa_s2 = hn::Set(d, law.peak_stress_pa * time_step_s * time_step_s);
  for (std::size_t i = first; i < last; i += lane_count) {
    const VecLanes fibre = fibre_of(slots, i, [&](std::size_t k) { return load_nodes(rows, slots.nodes[k] + i).at; });
    const Lane stretch = hn::Sqrt(dot(fibre, fibre));
    hn::StoreU(stretch, d, slots.stretch + i);
    const Lane volume = hn::LoadU(d, slots.volume_m3 + i);
    const Curve passive = passive_over_length(hn::Mul(stretch, per_optimal), law);
    const Lane scale = hn::Mul(scale_pa_s2, volume);
    const Lane slope = hn::Mul(passive.slope, per_optimal);
    hn::StoreU(hn::Mul(scale, hn::Sub(passive.value, hn::Mul(slope, stretch))), d, slots.pull + i);
    hn::StoreU(hn::Mul(scale, slope), d, slots.slope + i);
    hn::StoreU(hn::Zero(d), d, slots.multiplier + i);
    hn::StoreU(hn::Zero(d), d, slots.most + i);
    if (slots.gradients == nullptr) continue;
    const VecLanes along = hn::IfThenElseZero(hn::Gt(stretch, hn::Zero(d)), hn::Div(volume, stretch)) * fibre;
    for (std::size_t k = 0; k < 3; ++k) {
      add_to_nodes(hn::LoadU(d, slots.per_m[k] + i) * along, slots.gradients, slots.nodes[k] + i);
    }
  }
}

void project_fibres(FibreSlots slots, std::size_t first, std::size_t last, double per_time_step, NodeRow* rows) {
  const Lanes d;
  for (std::size_t i = first; i < last; i += lane_count) {
    const Lane slope = hn::LoadU(d, slots.slope + i);
    if (hn::AllTrue(d, hn::Eq(slope, hn::Zero(d)))) continue;  // all are slack
    std::array<NodeLanes, 3> nodes;
    for (std::size_t k = 0; k < 3; ++k) nodes[k] = load_nodes(rows, slots.nodes[k] + i);
    const VecLanes fibre = fibre_of(slots, i, [&](std::size_t k) { return nodes[k].at; });
    const Lane stretch = hn::Sqrt(dot(fibre, fibre));
    Lane weight = hn::Zero(d);
    for (std::size_t k = 0; k < 3; ++k) {
      const Lane per_m = hn::LoadU(d, slots.per_m[k] + i);
      weight = hn::Add(weight, hn::Mul(nodes[k].inverse_mass, hn::Mul(per_m, per_m)));
    }
    const Lane multiplier = hn::LoadU(d, slots.multiplier + i);
    const Lane pulled = hn::Add(hn::LoadU(d, slots.pull + i), hn::Mul(slope, stretch));
    const Lane wanted =
        hn::Sub(multiplier, hn::Div(hn::Add(multiplier, pulled), hn::Add(hn::Set(d, 1), hn::Mul(slope, weight))));
    // A fibre of no length has no direction.
    const Lane after =
        hn::IfThenElse(hn::Gt(stretch, hn::Zero(d)), hn::Min(wanted, hn::LoadU(d, slots.most + i)), multiplier);
    const Lane change = hn::Sub(after, multiplier);
    hn::StoreU(after, d, slots.multiplier + i);
    hn::StoreU(hn::Sub(hn::LoadU(d, slots.sum + i), hn::Mul(change, hn::Set(d, per_time_step))), d, slots.sum + i);
    const VecLanes along = hn::IfThenElseZero(hn::Gt(stretch, hn::Zero(d)), hn::Div(change, stretch)) * fibre;
    for (std::size_t k = 0; k < 3; ++k) {
      const VecLanes correction = hn::LoadU(d, slots.per_m[k] + i) * along;
      if (HWY_UNLIKELY(slots.impulses != nullptr)) add_to_nodes(correction, slots.impulses, slots.nodes[k] + i);
      nodes[k].at = nodes[k].at + nodes[k].inverse_mass * correction;
      store_nodes(nodes[k], rows, slots.nodes[k] + i);
    }
  }
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(begin_fibres);
HWY_EXPORT(project_fibres);

double FibreLaw::active_at(double stretch) const {
  constexpr double width = 0.45;
  const double off = stretch / optimal_stretch - 1;
  return portable::exp(-off * off / width);
}

double FibreLaw::active_over_speed(double speed) {
  constexpr double curvature = 0.25;
  constexpr double rise = (2 + 2 / curvature) / (most_over_speed - 1);
  if (speed <= -1) return 0;
  return speed < 0 ? (1 + speed) / (1 - speed / curvature) : (1 + speed * rise * most_over_speed) / (1 + speed * rise);
}

FibreConstraints::FibreConstraints(std::span<const FibreConstraint> constraints, std::span<const Body> bodies,
                                   const NodeOrder& order, const FibreLaw& law)
    : m_order(nodes_of<3>(constraints), order),
      m_law(law),
      m_volume_m3(by_slot(m_order, 0, [&](std::size_t i) { return constraints[i].volume_m3; })),
      m_muscle_of_slot(m_order.size()),
      m_gradients(order.size() + 1) {
  for (std::size_t k = 0; k < 3; ++k) {
    m_per_m[k] = by_slot(m_order, 0, [&](std::size_t i) { return constraints[i].per_m[k]; });
  }
  for (auto* values : {&m_stretch, &m_pull, &m_slope, &m_multipliers, &m_most, &m_sum}) values->resize(m_order.size());
  // Rows of a body are consecutive, in the order of bodies.
  for (const Body& body : bodies) {
    m_muscles.push_back(
        {static_cast<std::size_t>(body.first_node), static_cast<std::size_t>(body.last_node), body.activation});
  }
  for (std::size_t slot = 0; slot < m_order.size(); ++slot) {
    if (m_order.slots()[slot] < 0) continue;
    const FibreConstraint& constraint = constraints[static_cast<std::size_t>(m_order.slots()[slot])];
    m_muscle_of_slot[slot] = body_of(bodies, constraint.nodes[0]);
    m_muscles[m_muscle_of_slot[slot]].volume_m3 += constraint.volume_m3;
  }
}

FibreSlots FibreConstraints::slots(NodeRow* impulses) {
  return {.nodes = {m_order.row_offsets(0), m_order.row_offsets(1), m_order.row_offsets(2)},
          .per_m = {m_per_m[0].data(), m_per_m[1].data(), m_per_m[2].data()},
          .volume_m3 = m_volume_m3.data(),
          .stretch = m_stretch.data(),
          .pull = m_pull.data(),
          .slope = m_slope.data(),
          .multiplier = m_multipliers.data(),
          .most = m_most.data(),
          .sum = m_sum.data(),
          .gradients = m_activation > 0 ? m_gradients.data() : nullptr,
          .impulses = impulses};
}

void FibreConstraints::begin_substep(const NodeRows& rows, double activation, double time_step_s, const Team& team) {
  if (m_order.size() == 0) return;
  if (team.is_first()) {
    m_activation = activation;
    m_begins = true;
  }
  const Team::Share share = team.share(m_gradients.size());
  std::fill(m_gradients.begin() + static_cast<std::ptrdiff_t>(share.first),
            m_gradients.begin() + static_cast<std::ptrdiff_t>(share.last), NodeRow{});
  team.wait();
  m_order.for_each(team, [&](std::size_t first, std::size_t last) {
    HWY_DYNAMIC_DISPATCH(begin_fibres)(slots(nullptr), first, last, m_law, time_step_s, rows.data());
  });
  if (team.is_first()) find_stretches(time_step_s);
}

void FibreConstraints::find_stretches(double time_step_s) {
  for (Muscle& muscle : m_muscles) muscle.last_stretch = std::exchange(muscle.stretch, 0);
  for (std::size_t slot = 0; slot < m_stretch.size(); ++slot) {
    m_muscles[m_muscle_of_slot[slot]].stretch += m_volume_m3[slot] * m_stretch[slot];
  }
  for (Muscle& muscle : m_muscles) {
    muscle.stretch = muscle.volume_m3 > 0 ? muscle.stretch / muscle.volume_m3 : 1;
    muscle.rate_per_s = m_last_time_step_s > 0 ? (muscle.stretch - muscle.last_stretch) / m_last_time_step_s : 0;
    muscle.last_pa_s = m_last_time_step_s * std::exchange(muscle.stress_pa, 0);
  }
  m_last_time_step_s = time_step_s;
}

double FibreConstraints::stress_pa(const Muscle& muscle, const NodeRows& rows, double time_step_s) const {
  const double activation = muscle.activation_share * m_activation;
  const double at_rest_pa = activation * m_law.peak_stress_pa * m_law.active_at(muscle.stretch);
  if (!(m_law.fastest_per_s > 0) || !(muscle.volume_m3 > 0)) return at_rest_pa;
  double yields = 0;  // sum of inverse masses times squared gradients, m4 / kg
  for (std::size_t row = muscle.first_row; row < muscle.last_row; ++row) {
    yields += rows[row].inverse_mass * m_gradients[row].position().squaredNorm();
  }
  // The rate has in it what the last substep's pull did; a larger one slows the fibres down by as much.
  const double fastest_per_s = m_law.optimal_stretch * m_law.fastest_per_s * (0.25 + 0.75 * activation);
  const double speed_by_pull = yields / muscle.volume_m3 / fastest_per_s;
  const double before = muscle.rate_per_s / fastest_per_s + speed_by_pull * muscle.last_pa_s;
  double low = 0;
  double high = FibreLaw::most_over_speed;
  for (int i = 0; i < 48; ++i) {
    const double share = 0.5 * (low + high);
    const double bears = FibreLaw::active_over_speed(before - speed_by_pull * time_step_s * at_rest_pa * share);
    (bears > share ? low : high) = share;
  }
  return low * at_rest_pa;
}

void FibreConstraints::pull(NodeRows& rows, double time_step_s, const Team& team) {
  if (team.is_first()) {
    for (Muscle& muscle : m_muscles) {
      muscle.stress_pa = stress_pa(muscle, rows, time_step_s);
      muscle.active_n_m_s += muscle.volume_m3 * muscle.stress_pa * time_step_s;
    }
  }
  team.wait();
  const double squared_s2 = time_step_s * time_step_s;
  const Team::Share slots = team.share(m_stretch.size());
  for (std::size_t slot = slots.first; slot < slots.last; ++slot) {
    const Muscle& muscle = m_muscles[m_muscle_of_slot[slot]];
    m_most[slot] = squared_s2 * muscle.stress_pa * m_volume_m3[slot];
    const double slope = short_range_stiffness * m_most[slot];
    const double mean = muscle.stretch + time_step_s * muscle.rate_per_s;  // at the end of the substep
    m_slope[slot] += slope;
    m_pull[slot] -= slope * mean;
  }
  const Team::Share share = team.share(rows.size());
  for (const Muscle& muscle : m_muscles) {
    const std::size_t last = std::min(share.last, muscle.last_row);
    for (std::size_t row = std::max(share.first, muscle.first_row); row < last; ++row) {
      const NodeRow correction = -squared_s2 * muscle.stress_pa * m_gradients[row];
      if (rows.impulses() != nullptr) rows.impulses()[row] = rows.impulses()[row] + correction;
      rows[row].set_position(rows[row].position() + rows[row].inverse_mass * correction.position());
    }
  }
  team.wait();
}

void FibreConstraints::project(NodeRows& rows, double time_step_s, const Team& team) {
  if (m_order.size() == 0) return;
  if (m_begins && m_activation > 0) pull(rows, time_step_s, team);
  m_order.for_each(team, [&](std::size_t first, std::size_t last) {
    HWY_DYNAMIC_DISPATCH(project_fibres)(slots(rows.impulses()), first, last, 1 / time_step_s, rows.data());
  });
  if (team.is_first()) m_begins = false;  // which all have read
}

void FibreConstraints::forget_pulls() {
  std::ranges::fill(m_sum, 0.0);
  for (Muscle& muscle : m_muscles) muscle.active_n_m_s = 0;
}

std::vector<double> FibreConstraints::pulls_n_m_s() const {
  std::vector<double> pulls;
  for (const Muscle& muscle : m_muscles) pulls.push_back(muscle.active_n_m_s);
  for (std::size_t slot = 0; slot < m_sum.size(); ++slot) pulls[m_muscle_of_slot[slot]] += m_sum[slot];
  return pulls;
}

}  // namespace musclebench
#endif  // HWY_ONCE
