#include "core/contact/contact_impulses.hpp"

#include <algorithm>
#include <utility>

namespace musclebench {

namespace {

/// Bones that one node may touch at once; the pushes of more are not told apart.
constexpr std::size_t most_bones = 8;
/// Gauss-Seidel passes over so few unknowns: normals at an angle of 30 degrees or more give six digits.
constexpr int fit_passes = 100;

}  // namespace

ContactImpulses::ContactImpulses(std::vector<Body> muscles, std::size_t bones, std::span<const double> inverse_masses)
    : m_muscles(std::move(muscles)),
      m_bones(bones),
      m_inverse_masses(inverse_masses.begin(), inverse_masses.end()),
      m_known(inverse_masses.size()),
      m_impulses(colliders() * inverse_masses.size()),
      m_pushes(m_impulses.size()) {
  clear();
}

void ContactImpulses::clear() {
  std::ranges::fill(m_known, Vec3(Vec3::Zero()));
  std::ranges::fill(m_impulses, Vec3(Vec3::Zero()));
  std::ranges::fill(m_pushes, Vec3(Vec3::Zero()));
}

void ContactImpulses::add(int node, std::size_t collider, const Vec3& moved_kg_m, const Vec3& pushed_kg_m) {
  const auto index = static_cast<std::size_t>(node);
  const Vec3 impulse = m_per_time_step * moved_kg_m;
  m_known[index] += impulse;
  m_impulses[collider * m_known.size() + index] += impulse;
  m_pushes[collider * m_known.size() + index] += m_per_time_step * pushed_kg_m;
}

std::size_t ContactImpulses::other_side(int bone, const std::array<int, 4>& nodes, const std::array<double, 4>& weights,
                                        std::size_t k) const {
  if (bone >= 0) return static_cast<std::size_t>(bone);
  for (std::size_t other = 0; other < nodes.size(); ++other) {
    if (weights[other] * weights[k] < 0) return of_muscle(body_of(m_muscles, nodes[other]));
  }
  return unknown();
}

void ContactImpulses::add_to_bones(int node, const Vec3& moved_kg_m, std::span<const Contact> contacts) {
  if (contacts.size() > most_bones) return;
  std::array<double, most_bones> pushes{};
  double sum = 0;
  for (int pass = 0; pass < (contacts.size() > 1 ? fit_passes : 1); ++pass) {
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      Vec3 rest = moved_kg_m;
      for (std::size_t j = 0; j < contacts.size(); ++j) {
        if (j != i) rest -= pushes[j] * contacts[j].normal;
      }
      pushes[i] = std::max(0.0, contacts[i].normal.dot(rest));
    }
  }
  Vec3 rest = moved_kg_m;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    rest -= pushes[i] * contacts[i].normal;
    sum += pushes[i];
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double share = sum > 0 ? pushes[i] / sum : 1 / static_cast<double>(contacts.size());
    const Vec3 pushed = pushes[i] * contacts[i].normal;
    add(node, static_cast<std::size_t>(contacts[i].bone), pushed + share * rest, pushed);
  }
}

}  // namespace musclebench
