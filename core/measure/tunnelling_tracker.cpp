#include "core/measure/tunnelling_tracker.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace musclebench {

TunnellingTracker::TunnellingTracker(int bones, int nodes)
    : m_states(static_cast<std::size_t>(bones), std::vector<NodeState>(static_cast<std::size_t>(nodes))) {}

void TunnellingTracker::NodeState::enter(const Vec3& normal) {
  inside = true;
  entry_normal = normal;
  deepest_m = 0;
}

void TunnellingTracker::NodeState::leave(const Vec3& normal, double grazing_m) {
  inside = false;
  if (entry_normal.dot(normal) < opposed_cosine && deepest_m > grazing_m) tunnelled = !tunnelled;
}

void TunnellingTracker::NodeState::sample_depth(const RefereeTree& tree, const Vec3& inner_point, long& work) {
  deepest_m = std::max(deepest_m, std::sqrt(tree.closest(inner_point, -1, &work).squared_distance_m2));
}

int TunnellingTracker::update(const Referee& referee, std::span<const RigidMotion> poses,
                              std::span<const Vec3> positions, std::span<const int> nodes,
                              std::span<const Contact> truth) {
  assert(poses.size() == m_states.size());
  m_work = 0;
  auto contact = truth.begin();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int bone = static_cast<int>(i);
    const RefereeTree& tree = referee.tree(bone);
    for (const int node : nodes) {
      const bool inside = contact != truth.end() && contact->bone == bone && contact->node == node;
      const Contact* truth_here = inside ? &*contact++ : nullptr;
      const Vec3 rest_point = poses[i].apply_inverse(positions[static_cast<std::size_t>(node)]);
      if (!rest_point.allFinite()) continue;
      NodeState& state = m_states[i][static_cast<std::size_t>(node)];
      const Vec3 point = rest_point - tree.centre_m();
      const bool same_side = state.seen && state.inside == inside;
      const bool far = same_side && (point - state.point_m).norm() < referee.least_distance(bone, node, rest_point);
      if (state.seen && far && inside) state.sample_depth(tree, 0.5 * (state.point_m + point), m_work);
      if (state.seen && !far) follow_crossings(tree, point, state);
      // The inside flag is authoritative; crossings may be missing for open surfaces and in the first frame.
      if (inside && !state.inside) state.enter(poses[i].rotation.transpose() * truth_here->normal);
      if (!inside && state.inside)
        state.leave(referee.closest(bone, rest_point, &m_work).normal, grazing_depth * tree.diagonal_m());
      if (inside) state.deepest_m = std::max(state.deepest_m, truth_here->depth_m);
      state.point_m = point;
      state.seen = true;
    }
  }
  return tunnelled_nodes();
}

void TunnellingTracker::follow_crossings(const RefereeTree& tree, const Vec3& point, NodeState& state) {
  tree.cross(state.point_m, point, m_crossings, &m_work);
  if (m_crossings.empty() && !state.inside) return;
  // Where components of the surface overlap, only the outermost crossing enters or leaves the bone.
  int layers = state.inside ? 1 : 0;
  if (tree.closed() && state.inside)
    layers = std::max(1, static_cast<int>(std::lround(tree.winding_number(state.point_m, &m_work))));
  // What touches the surface counts as outside, but its path may begin inside.
  if (tree.closed() && !state.inside && !m_crossings.front().entering) {
    state.enter(tree.face_normal(tree.closest(state.point_m, -1, &m_work).slot));
    layers = 1;
  }
  double inside_since = 0;
  const auto sample_the_middle = [&](double until) {
    state.sample_depth(tree, state.point_m + 0.5 * (inside_since + until) * (point - state.point_m), m_work);
  };
  for (const SurfaceCrossing& crossing : m_crossings) {
    layers += crossing.entering ? 1 : -1;
    if (layers > 0 && !state.inside) {
      state.enter(tree.face_normal(crossing.slot));
      inside_since = crossing.share;
    } else if (layers <= 0 && state.inside) {
      sample_the_middle(crossing.share);
      state.leave(tree.face_normal(crossing.slot), grazing_depth * tree.diagonal_m());
    }
  }
  if (state.inside) sample_the_middle(1);
}

bool TunnellingTracker::tunnelled(int node) const {
  return std::any_of(m_states.begin(), m_states.end(), [node](const std::vector<NodeState>& states) {
    return states[static_cast<std::size_t>(node)].tunnelled;
  });
}

int TunnellingTracker::tunnelled_nodes() const {
  int count = 0;
  const std::size_t nodes = m_states.empty() ? 0 : m_states.front().size();
  for (std::size_t node = 0; node < nodes; ++node) count += tunnelled(static_cast<int>(node)) ? 1 : 0;
  return count;
}

std::size_t TunnellingTracker::bytes() const {
  std::size_t sum = m_crossings.capacity() * sizeof(SurfaceCrossing);
  for (const std::vector<NodeState>& states : m_states) sum += states.capacity() * sizeof(NodeState);
  return sum;
}

}  // namespace musclebench
