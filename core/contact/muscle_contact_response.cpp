#include "core/contact/muscle_contact_response.hpp"

#include <algorithm>
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
    : m_triangles(triangles), m_steps(std::move(steps)), m_solver(std::move(inverse_masses)) {}

void MuscleContactResponse::resolve(std::span<const MuscleContact> contacts, std::span<Vec3> start,
                                    std::span<Vec3> predicted) {
  m_rows.clear();
  for (const MuscleContact& contact : contacts) {
    const auto& [a, b, c] = m_triangles[static_cast<std::size_t>(contact.triangle)];
    const Vec3& weights = contact.weights;
    m_rows.push_back({.nodes = {contact.node, a, b, c},
                      .weights = {1, -weights.x(), -weights.y(), -weights.z()},
                      .normal = contact.normal,
                      .start_normal = contact.normal,
                      .steps = m_steps.of(contact)});
  }
  m_solver.solve(m_rows, start, predicted);
}

}  // namespace musclebench
