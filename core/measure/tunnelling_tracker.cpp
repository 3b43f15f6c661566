#include "core/measure/tunnelling_tracker.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace musclebench {

TunnellingTracker::TunnellingTracker(int bones, int nodes)
    : m_passages(static_cast<std::size_t>(bones), std::vector<Passage>(static_cast<std::size_t>(nodes))) {}

void TunnellingTracker::Passage::enter(const Vec3& normal) {
  inside = true;
  entry_normal = normal;
  deepest_m = 0;
}

void TunnellingTracker::Passage::leave(const Vec3& normal, double grazing_m) {
  inside = false;
  if (entry_normal.dot(normal) < opposed_cosine && deepest_m > grazing_m) tunnelled = !tunnelled;
}

void TunnellingTracker::Passage::sample_depth(const RefereeTree& tree, const Vec3& inner_point, long& work) {
  deepest_m = std::max(deepest_m, std::sqrt(tree.closest(inner_point, -1, &work).squared_distance_m2));
}

int TunnellingTracker::update(const Referee& referee, std::span<const RigidMotion> poses,
                              std::span<const Vec3> positions, std::span<const int> nodes,
                              std::span<const Contact> truth) {
  assert(poses.size() == m_passages.size());
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
      Passage& passage = m_passages[i][static_cast<std::size_t>(node)];
      const Vec3 point = rest_point - tree.centre_m();
      const bool same_side = passage.seen && passage.inside == inside;
      const bool far = same_side && (point - passage.point_m).norm() < referee.least_distance(bone, node, rest_point);
      if (passage.seen && far && inside) passage.sample_depth(tree, 0.5 * (passage.point_m + point), m_work);
      if (passage.seen && !far) follow_crossings(tree, point, passage);
      // The inside flag is authoritative; crossings may be missing for open surfaces and in the first frame.
      if (inside && !passage.inside) passage.enter(poses[i].rotation.transpose() * truth_here->normal);
      if (!inside && passage.inside)
        passage.leave(referee.closest(bone, rest_point, &m_work).normal, grazing_depth * tree.diagonal_m());
      if (inside) passage.deepest_m = std::max(passage.deepest_m, truth_here->depth_m);
      passage.point_m = point;
      passage.seen = true;
    }
  }
  return tunnelled_nodes();
}

void TunnellingTracker::follow_crossings(const RefereeTree& tree, const Vec3& point, Passage& passage) {
  tree.cross(passage.point_m, point, m_crossings, &m_work);
  if (m_crossings.empty() && !passage.inside) return;
  // Where components of the surface overlap, only the outermost crossing enters or leaves the bone.
  int layers = passage.inside ? 1 : 0;
  if (tree.closed() && passage.inside)
    layers = std::max(1, static_cast<int>(std::lround(tree.winding_number(passage.point_m, &m_work))));
  // What touches the surface counts as outside, but its path may begin inside.
  if (tree.closed() && !passage.inside && !m_crossings.front().entering) {
    passage.enter(tree.face_normal(tree.closest(passage.point_m, -1, &m_work).slot));
    layers = 1;
  }
  double inside_since = 0;
  const auto sample_the_middle = [&](double until) {
    passage.sample_depth(tree, passage.point_m + 0.5 * (inside_since + until) * (point - passage.point_m), m_work);
  };
  for (const SurfaceCrossing& crossing : m_crossings) {
    layers += crossing.entering ? 1 : -1;
    if (layers > 0 && !passage.inside) {
      passage.enter(tree.face_normal(crossing.slot));
      inside_since = crossing.share;
    } else if (layers <= 0 && passage.inside) {
      sample_the_middle(crossing.share);
      passage.leave(tree.face_normal(crossing.slot), grazing_depth * tree.diagonal_m());
    }
  }
  if (passage.inside) sample_the_middle(1);
}

bool TunnellingTracker::tunnelled(int node) const {
  return std::any_of(m_passages.begin(), m_passages.end(), [node](const std::vector<Passage>& passages) {
    return passages[static_cast<std::size_t>(node)].tunnelled;
  });
}

int TunnellingTracker::tunnelled_nodes() const {
  int count = 0;
  const std::size_t nodes = m_passages.empty() ? 0 : m_passages.front().size();
  for (std::size_t node = 0; node < nodes; ++node) count += tunnelled(static_cast<int>(node)) ? 1 : 0;
  return count;
}

std::size_t TunnellingTracker::bytes() const {
  std::size_t sum = m_crossings.capacity() * sizeof(SurfaceCrossing);
  for (const std::vector<Passage>& passages : m_passages) sum += passages.capacity() * sizeof(Passage);
  return sum;
}

}  // namespace musclebench
