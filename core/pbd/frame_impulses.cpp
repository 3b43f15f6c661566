#include "core/pbd/frame_impulses.hpp"

#include <algorithm>
#include <utility>

namespace musclebench {

namespace {

/// Of the impulses that differ by it. A node a metre from the origin that moves by a micrometre has ten digits of it.
constexpr double rounding = 1e-6;

}  // namespace

FrameImpulses::FrameImpulses(std::vector<Body> muscles, std::size_t bones, const NodeOrder& order,
                             std::span<const double> inverse_masses, std::size_t effects)
    : m_by_collider(std::move(muscles), bones, inverse_masses),
      m_order(order),
      m_of_effects(effects, std::vector<NodeRow>(inverse_masses.size() + 1)),
      m_velocities_before(inverse_masses.size()),
      m_contact_sum(inverse_masses.size()),
      m_contact_size(inverse_masses.size()),
      m_moved_m(inverse_masses.size()),
      m_known(inverse_masses.size()),
      m_contacts(inverse_masses.size()) {
  for (auto& contacts : m_contacts) contacts.reserve(bones);
}

void FrameImpulses::begin_frame(double time_step_s) {
  m_duration_s = 0;
  m_time_step_s = time_step_s;
  m_by_collider.clear();
  m_by_collider.set_time_step(time_step_s);
  for (auto& rows : m_of_effects) std::ranges::fill(rows, NodeRow());
  std::ranges::fill(m_contact_sum, Vec3(Vec3::Zero()));
  std::ranges::fill(m_contact_size, 0.0);
}

void FrameImpulses::end_frame() {
  const double largest = m_contact_size.empty() ? 0 : std::ranges::max(m_contact_size);
  for (int node = 0; node < static_cast<int>(m_contact_sum.size()); ++node) {
    if (m_by_collider.inverse_mass(node) == 0) continue;
    const Vec3 unknown = of_contacts(node) - m_by_collider.known(node);
    if (unknown.norm() <= rounding * std::max(m_contact_size[static_cast<std::size_t>(node)], rounding * largest)) {
      continue;
    }
    m_by_collider.add(node, m_by_collider.unknown(), m_time_step_s * unknown, Vec3::Zero());
  }
}

void FrameImpulses::begin_contacts(std::span<const Vec3> start, std::span<const Vec3> predicted) {
  for (std::size_t node = 0; node < m_moved_m.size(); ++node) {
    m_moved_m[node] = predicted[node] - start[node];
    m_known[node] = m_by_collider.known(static_cast<int>(node));
  }
}

void FrameImpulses::add_contacts(std::span<const Vec3> start, std::span<const Vec3> predicted,
                                 std::span<const Contact> contacts) {
  for (const Contact& contact : contacts) m_contacts[static_cast<std::size_t>(contact.node)].push_back(contact);
  for (std::size_t i = 0; i < m_moved_m.size(); ++i) {
    const Vec3 change_m = (predicted[i] - start[i]) - m_moved_m[i];
    const auto node = static_cast<int>(i);
    const double inverse_mass = m_by_collider.inverse_mass(node);
    if (change_m.isZero(0) || inverse_mass == 0) continue;
    const Vec3 impulse = change_m / (inverse_mass * m_time_step_s);
    m_contact_sum[i] += impulse;
    m_contact_size[i] += impulse.norm();
    if (m_contacts[i].empty()) continue;
    const Vec3 of_rows = m_by_collider.known(node) - m_known[i];
    m_by_collider.add_to_bones(node, m_time_step_s * (impulse - of_rows), m_contacts[i]);
  }
  for (const Contact& contact : contacts) m_contacts[static_cast<std::size_t>(contact.node)].clear();
}

}  // namespace musclebench
