#include "core/contact/muscle_contact_response.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace musclebench {

PairSteps::PairSteps(std::vector<Body> muscles, std::vector<MusclePair> touching, std::vector<int> steps)
    : most(steps.empty() ? 1 : std::ranges::max(steps)),
      bodies(std::move(muscles)),
      pairs(std::move(touching)),
      of_pairs(std::move(steps)) {}

int PairSteps::of(const MuscleContact& contact) const {
  if (of_pairs.empty()) return most;
  const auto muscle = static_cast<int>(body_of(bodies, contact.node));
  return of_pairs[pair_index(pairs, muscle, contact.muscle)];
}

MuscleContactResponse::MuscleContactResponse(std::span<const Triangle> triangles, std::vector<double> inverse_masses,
                                             PairSteps steps)
    : m_triangles(triangles),
      m_inverse_masses(std::move(inverse_masses)),
      m_steps(std::move(steps)),
      m_loads(m_inverse_masses.size(), 0),
      m_corrections(m_inverse_masses.size(), Vec3::Zero()),
      m_start_corrections(m_inverse_masses.size(), Vec3::Zero()) {}

std::array<MuscleContactResponse::Arm, 4> MuscleContactResponse::arms_of(const MuscleContact& contact) const {
  const auto& [a, b, c] = m_triangles[static_cast<std::size_t>(contact.triangle)];
  const Vec3& weights = contact.weights;
  return {{{static_cast<std::size_t>(contact.node), 1},
           {static_cast<std::size_t>(a), -weights.x()},
           {static_cast<std::size_t>(b), -weights.y()},
           {static_cast<std::size_t>(c), -weights.z()}}};
}

void MuscleContactResponse::collect_moved(std::span<const MuscleContact> contacts) {
  m_moved.clear();
  for (const MuscleContact& contact : contacts) {
    for (const Arm& arm : arms_of(contact)) {
      if (m_loads[arm.node] == 0 && arm.weight != 0) m_moved.push_back(static_cast<int>(arm.node));
      m_loads[arm.node] += std::abs(arm.weight);
    }
  }
  std::sort(m_moved.begin(), m_moved.end());
}

void MuscleContactResponse::resolve(std::span<const MuscleContact> contacts, std::span<Vec3> start,
                                    std::span<Vec3> predicted) {
  collect_moved(contacts);
  m_steps_of_contacts.clear();
  for (const MuscleContact& contact : contacts) m_steps_of_contacts.push_back(m_steps.of(contact));
  for (int step = 0; step < m_steps.most; ++step) {
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (step >= m_steps_of_contacts[i]) continue;
      const MuscleContact& contact = contacts[i];
      const std::array<Arm, 4> arms = arms_of(contact);
      double gap_m = 0;
      double start_gap_m = 0;
      double row_sum = 0;
      for (const Arm& arm : arms) {
        gap_m += arm.weight * contact.normal.dot(predicted[arm.node] - predicted[arms[0].node]);
        start_gap_m += arm.weight * contact.normal.dot(start[arm.node] - start[arms[0].node]);
        row_sum += m_inverse_masses[arm.node] * std::abs(arm.weight) * m_loads[arm.node];
      }
      if (!(gap_m < 0) || !(row_sum > 0)) {  // free, or bones hold both sides
        continue;
      }
      const double began_inside = std::clamp(start_gap_m / gap_m, 0.0, 1.0);
      for (const Arm& arm : arms) {
        const Vec3 correction = (-gap_m / row_sum * m_inverse_masses[arm.node] * arm.weight) * contact.normal;
        m_corrections[arm.node] += correction;
        m_start_corrections[arm.node] += began_inside * correction;
      }
    }
    for (const int node : m_moved) {
      const auto i = static_cast<std::size_t>(node);
      predicted[i] += std::exchange(m_corrections[i], Vec3::Zero());
      start[i] += std::exchange(m_start_corrections[i], Vec3::Zero());
    }
  }
  for (const int node : m_moved) m_loads[static_cast<std::size_t>(node)] = 0;
}

}  // namespace musclebench
