// Contact with bones in the loop: all that a simulation calls of its backend and response.
#include <algorithm>
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
  m_response.resolve(m_backend, {m_positions, m_previous_poses, m_poses}, m_contacts, m_predicted);
  for (const Contact& contact : m_contacts) {
    m_rows[m_order.row_of(contact.node)].set_position(m_predicted[contact.node]);
  }
}

}  // namespace musclebench
