#include "core/measure/tunnelling_tracker.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace musclebench {

TunnellingTracker::TunnellingTracker(int bones, int nodes)
    : m_ways(static_cast<std::size_t>(bones), std::vector<Way>(static_cast<std::size_t>(nodes))) {}

void TunnellingTracker::Way::enter(const Vec3& normal) {
  inside = true;
  entry_normal = normal;
  deepest_m = 0;
}

void TunnellingTracker::Way::leave(const Vec3& normal, double grazing_m) {
  inside = false;
  if (entry_normal.dot(normal) < opposed_cosine && deepest_m > grazing_m) tunnelled = !tunnelled;
}

void TunnellingTracker::Way::look(const RefereeTree& tree, const Vec3& inner_point) {
  deepest_m = std::max(deepest_m, std::sqrt(tree.closest(inner_point).squared_distance_m2));
}

int TunnellingTracker::update(const Referee& referee, std::span<const RigidMotion> poses,
                              std::span<const Vec3> positions, std::span<const int> nodes,
                              std::span<const Contact> truth) {
  assert(poses.size() == m_ways.size());
  auto contact = truth.begin();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int bone = static_cast<int>(i);
    const RefereeTree& tree = referee.tree(bone);
    for (const int node : nodes) {
      const bool inside = contact != truth.end() && contact->bone == bone && contact->node == node;
      const Contact* truth_here = inside ? &*contact++ : nullptr;
      const Vec3 rest_point = poses[i].apply_inverse(positions[static_cast<std::size_t>(node)]);
      if (!rest_point.allFinite()) continue;
      Way& way = m_ways[i][static_cast<std::size_t>(node)];
      const Vec3 point = rest_point - tree.centre_m();
      const bool same_side = way.seen && way.inside == inside;
      const bool far = same_side && (point - way.point_m).norm() < referee.least_distance(bone, node, rest_point);
      if (way.seen && far && inside) way.look(tree, 0.5 * (way.point_m + point));
      if (way.seen && !far) follow_crossings(tree, point, way);
      // The sides are sure; crossings may lack where the surface is open, and for a node that is seen first.
      if (inside && !way.inside) way.enter(poses[i].rotation.transpose() * truth_here->normal);
      if (!inside && way.inside) way.leave(referee.closest(bone, rest_point).normal, grazing_depth * tree.diagonal_m());
      if (inside) way.deepest_m = std::max(way.deepest_m, truth_here->depth_m);
      way.point_m = point;
      way.seen = true;
    }
  }
  return tunnelled_nodes();
}

void TunnellingTracker::follow_crossings(const RefereeTree& tree, const Vec3& point, Way& way) {
  tree.cross(way.point_m, point, m_crossings);
  if (m_crossings.empty() && !way.inside) return;
  // Where components of the surface overlap, only the outermost crossing enters or leaves the bone.
  int layers = way.inside ? 1 : 0;
  if (tree.closed() && way.inside)
    layers = std::max(1, static_cast<int>(std::lround(tree.winding_number(way.point_m))));
  // What touches the surface counts as outside, but its way may begin inside.
  if (tree.closed() && !way.inside && !m_crossings.front().entering) {
    way.enter(tree.face_normal(tree.closest(way.point_m).slot));
    layers = 1;
  }
  double inside_since = 0;
  const auto look_in_the_middle = [&](double until) {
    way.look(tree, way.point_m + 0.5 * (inside_since + until) * (point - way.point_m));
  };
  for (const SurfaceCrossing& crossing : m_crossings) {
    layers += crossing.entering ? 1 : -1;
    if (layers > 0 && !way.inside) {
      way.enter(tree.face_normal(crossing.slot));
      inside_since = crossing.share;
    } else if (layers <= 0 && way.inside) {
      look_in_the_middle(crossing.share);
      way.leave(tree.face_normal(crossing.slot), grazing_depth * tree.diagonal_m());
    }
  }
  if (way.inside) look_in_the_middle(1);
}

bool TunnellingTracker::tunnelled(int node) const {
  return std::any_of(m_ways.begin(), m_ways.end(),
                     [node](const std::vector<Way>& ways) { return ways[static_cast<std::size_t>(node)].tunnelled; });
}

int TunnellingTracker::tunnelled_nodes() const {
  int count = 0;
  const std::size_t nodes = m_ways.empty() ? 0 : m_ways.front().size();
  for (std::size_t node = 0; node < nodes; ++node) count += tunnelled(static_cast<int>(node)) ? 1 : 0;
  return count;
}

std::size_t TunnellingTracker::bytes() const {
  std::size_t sum = m_crossings.capacity() * sizeof(SurfaceCrossing);
  for (const std::vector<Way>& ways : m_ways) sum += ways.capacity() * sizeof(Way);
  return sum;
}

}  // namespace musclebench
