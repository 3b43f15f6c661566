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

namespace {

/// Of a row's nodes, by its weights: how far its two points are apart.
Vec3 sum_over(const ContactRow& row, std::span<const Vec3> positions) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] != 0) sum += row.weights[k] * positions[static_cast<std::size_t>(row.nodes[k])];
  }
  return sum;
}

}  // namespace

MuscleContactResponse::MuscleContactResponse(std::span<const Triangle> triangles, std::vector<double> inverse_masses,
                                             PairSteps steps)
    : m_triangles(triangles), m_steps(std::move(steps)), m_solver(std::move(inverse_masses)) {}

void MuscleContactResponse::resolve(std::span<const MuscleContact> contacts, std::span<Vec3> start,
                                    std::span<Vec3> predicted, double depenetration_m) {
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
  if (m_friction > 0) find_approaches(start, predicted);
  m_solver.lay_out_slowly(m_rows, start, predicted, depenetration_m);
  m_solver.solve(m_rows, start, predicted);
  if (m_friction > 0) rub(start, predicted);
}

void MuscleContactResponse::find_approaches(std::span<const Vec3> start, std::span<const Vec3> predicted) {
  m_approaches_m.clear();
  for (const ContactRow& row : m_rows) {
    m_approaches_m.push_back(row.normal.dot(sum_over(row, predicted) - sum_over(row, start)));
  }
}

void MuscleContactResponse::rub(std::span<const Vec3> start, std::span<Vec3> predicted) {
  m_slides.clear();
  for (std::size_t i = 0; i < m_rows.size(); ++i) {
    const ContactRow& row = m_rows[i];
    const Vec3 moved = sum_over(row, predicted) - sum_over(row, start);
    const double along_normal_m = row.normal.dot(moved);
    const double push_m = std::max(0.0, along_normal_m - m_approaches_m[i]);
    const Vec3 slide = moved - along_normal_m * row.normal;
    const double slide_m = slide.norm();
    const double undone_m = std::min(slide_m, m_friction * push_m);
    m_slides.push_back(slide_m > 0 ? Vec3(undone_m / slide_m * slide) : Vec3::Zero());
  }
  m_solver.displace(m_rows, m_slides, predicted);
}

}  // namespace musclebench
