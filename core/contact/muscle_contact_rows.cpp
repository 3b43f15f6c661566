#include "core/contact/muscle_contact_rows.hpp"

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

void rows_of(std::span<const MuscleContact> contacts, std::span<const Triangle> triangles, const PairSteps& steps,
             std::vector<ContactRow>& rows) {
  rows.clear();
  for (const MuscleContact& contact : contacts) {
    const auto& [a, b, c] = triangles[static_cast<std::size_t>(contact.triangle)];
    const Vec3& weights = contact.weights;
    rows.push_back({.nodes = {contact.node, a, b, c},
                    .weights = {1, -weights.x(), -weights.y(), -weights.z()},
                    .normal = contact.normal,
                    .start_normal = contact.normal,
                    .steps = steps.of(contact)});
  }
}

}  // namespace musclebench
