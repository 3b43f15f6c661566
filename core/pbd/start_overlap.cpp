#include "core/pbd/start_overlap.hpp"

#include <algorithm>

namespace musclebench {

namespace {

/// Of a contact's depth. What lies flush with a bone is in it by rounding.
constexpr double least_share = 1e-6;

/// Where a bone that takes it along would have brought the node from where the substep began.
Vec3 carried(const StartOverlap::Step& step, int bone, const Vec3& start) {
  const auto i = static_cast<std::size_t>(bone);
  return step.bone_poses[i].apply(step.previous_bone_poses[i].apply_inverse(start));
}

/// Whether a plane at the bone's surface had the node on its inner side when the substep began. A backend without
/// normals has responses that keep such a node where it is in the bone.
bool began_inside(const StartOverlap::Step& step, const Contact& contact, const Vec3& start, const Vec3& predicted) {
  const double moved_in_m = contact.normal.dot(carried(step, contact.bone, start) - predicted);
  return contact.depth_m - moved_in_m > least_share * contact.depth_m;
}

}  // namespace

StartOverlap::StartOverlap(std::size_t nodes) : m_state(nodes, State::began_outside) {
  m_nodes.reserve(nodes);
  m_bones.reserve(nodes);
  m_before.reserve(nodes);
}

void StartOverlap::before_response(const Step& step, std::span<const Vec3> start, std::span<const Vec3> predicted) {
  if (m_is_first_step) {
    for (const Contact& contact : step.contacts) {
      const auto node = static_cast<std::size_t>(contact.node);
      if (!began_inside(step, contact, start[node], predicted[node])) continue;
      m_state[node] = State::began_inside;
      m_are_any = true;
    }
    m_is_first_step = false;
  }
  m_nodes.clear();
  m_bones.clear();
  m_before.clear();
  // Contacts are ordered by bone, so that a node's first bone comes first.
  for (const Contact& contact : step.contacts) {
    const auto node = static_cast<std::size_t>(contact.node);
    if (m_state[node] != State::began_inside) continue;
    m_state[node] = State::listed;
    m_nodes.push_back(contact.node);
    m_bones.push_back(contact.bone);
    m_before.push_back(predicted[node]);
  }
  for (const int node : m_nodes) m_state[static_cast<std::size_t>(node)] = State::began_inside;
}

void StartOverlap::after_response(const Step& step, double most_m, std::span<Vec3> start, std::span<Vec3> predicted) {
  for (std::size_t i = 0; i < m_nodes.size(); ++i) {
    const auto node = static_cast<std::size_t>(m_nodes[i]);
    const Vec3 correction = predicted[node] - m_before[i];
    const double length_m = correction.norm();
    if (!(length_m > 0)) continue;
    const Vec3 out = correction / length_m;
    // What the node came in by in this substep is undone as always, and so takes its speed away.
    const double moved_in_m = std::clamp(out.dot(carried(step, m_bones[i], start[node]) - m_before[i]), 0.0, length_m);
    const double laid_out_m = std::min(length_m - moved_in_m, most_m);
    predicted[node] = m_before[i] + (moved_in_m + laid_out_m) * out;
    start[node] += laid_out_m * out;
  }
}

}  // namespace musclebench
