// Contact with bones in the loop: all that a simulation calls of its backend and response.
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/pbd/simulation.hpp"

namespace musclebench {

void Simulation::find_contacts() {
  {
    const ScopedTimer timer(m_times.update_ns);
    m_backend.update(m_poses, m_predicted);
  }
  {
    const ScopedTimer timer(m_times.detect_ns);
    m_backend.detect(m_predicted, m_free_nodes, m_contacts);
  }
  std::ranges::transform(m_backend.pair_times(), m_times.pairs_ns, m_times.pairs_ns.begin(), std::plus<>());
}

void Simulation::respond() {
  const ScopedTimer timer(m_times.respond_ns);
  const bool looks_at_overlap = std::isfinite(m_depenetration_m) && m_start_overlap.may_be_any();
  const StartOverlap::Step step{m_contacts, m_previous_poses, m_poses};
  if (looks_at_overlap) m_start_overlap.before_response(step, m_positions, m_predicted);
  m_response.resolve(m_backend, {m_positions, m_previous_poses, m_poses}, m_contacts, m_predicted);
  if (looks_at_overlap) {
    m_start_overlap.after_response(step, m_depenetration_m, m_positions, m_predicted);
  }
  for (const Contact& contact : m_contacts) {
    const auto row = static_cast<std::size_t>(m_order.row_of(contact.node));
    m_rows[row].set_position(m_predicted[contact.node]);
    if (looks_at_overlap) m_start[row].set_position(m_positions[contact.node]);
  }
}

}  // namespace musclebench
