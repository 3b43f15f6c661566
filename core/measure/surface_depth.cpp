#include "core/measure/surface_depth.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace musclebench {
namespace {

/// Rounding errors of a distance or a movement stay far below this share of the lengths that they come from. Of a
/// bone's diagonal it is more than `touching_distance_m`, so that no side is concluded from a node that touches.
constexpr double depth_rounding = 0x1p-39;

double longest_edge(const Vec3& a, const Vec3& b, const Vec3& c) {
  return std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
}

double radius_about(const Vec3& centre, const Vec3& a, const Vec3& b, const Vec3& c) {
  return std::sqrt(std::max({(a - centre).squaredNorm(), (b - centre).squaredNorm(), (c - centre).squaredNorm()}));
}

constexpr auto less_urgent = [](const auto& one, const auto& other) { return one.excess_m < other.excess_m; };

Vec3 weights_in(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& point) {
  const Vec3 normal = (b - a).cross(c - a);
  const double whole = normal.squaredNorm();
  if (!(whole > 0)) return Vec3::Constant(1.0 / 3);
  const double weight_b = (point - a).cross(c - a).dot(normal) / whole;
  const double weight_c = (b - a).cross(point - a).dot(normal) / whole;
  return {1 - weight_b - weight_c, weight_b, weight_c};
}

}  // namespace

SurfaceDepthMeter::SurfaceDepthMeter(std::span<const Triangle> triangles, std::span<const int> carriers, int bones,
                                     std::span<const char> left_out)
    : m_triangles(triangles.begin(), triangles.end()),
      m_counting(static_cast<std::size_t>(bones)),
      m_caches(static_cast<std::size_t>(bones)),
      m_carriers(carriers.begin(), carriers.end()) {
  const auto carrier = [&](int node) { return m_carriers[static_cast<std::size_t>(node)]; };
  for (int bone = 0; bone < bones; ++bone) {
    if (!left_out.empty() && left_out[static_cast<std::size_t>(bone)] != 0) continue;
    std::vector<int>& counting = m_counting[static_cast<std::size_t>(bone)];
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const Triangle& nodes = triangles[t];
      const bool some_free = std::any_of(nodes.begin(), nodes.end(), [&](int node) { return carrier(node) < 0; });
      const bool carried = std::any_of(nodes.begin(), nodes.end(), [&](int node) { return carrier(node) == bone; });
      if (some_free && !carried) counting.push_back(static_cast<int>(t));
    }
    m_caches[static_cast<std::size_t>(bone)].resize(counting.size());
  }
}

double SurfaceDepthMeter::limit_m(const RefereeTree& tree) const {
  return (1 + relative_tolerance) * m_best.depth_m + absolute_tolerance * tree.diagonal_m();
}

DeepestSurfacePoint SurfaceDepthMeter::measure(const Referee& referee, std::span<const RigidMotion> poses,
                                               std::span<const Vec3> positions, std::span<const Contact> truth,
                                               long budget) {
  assert(poses.size() == m_counting.size() && positions.size() == m_carriers.size());
  m_work = 0;
  start_where_it_was_deepest(referee, poses, positions);
  for (const Contact& contact : truth) {
    if (contact.depth_m > m_best.depth_m) {
      m_best = {contact.depth_m, 0, true, contact.bone, -1, positions[static_cast<std::size_t>(contact.node)]};
      m_best_out_of_bone = poses[static_cast<std::size_t>(contact.bone)].rotation.transpose() * contact.normal;
    }
  }
  m_parts.clear();
  std::size_t first = 0;
  for (int bone = 0; bone < std::ssize(poses); ++bone) {
    first = take_depths(bone, truth, first);
    if (m_counting[static_cast<std::size_t>(bone)].empty()) continue;
    place_nodes(bone, referee, poses[static_cast<std::size_t>(bone)], positions);
    collect_parts(bone, referee.tree(bone));
  }
  refine_parts(referee, budget);
  for (std::size_t bone = 0; bone < poses.size(); ++bone) {
    m_best.bound_m = std::max(m_best.bound_m, limit_m(referee.tree(static_cast<int>(bone))));
  }
  for (const Part& part : m_parts) {
    if (part.bound_m <= limit_m(referee.tree(part.bone))) continue;
    m_best.bound_m = std::max(m_best.bound_m, part.bound_m);
    m_best.complete = false;
  }
  if (m_best.triangle >= 0) {
    m_best.point_m = poses[static_cast<std::size_t>(m_best.bone)].apply(m_best_rest_m);
    const Triangle& nodes = m_triangles[static_cast<std::size_t>(m_best.triangle)];
    const auto at = [&](std::size_t k) -> const Vec3& { return positions[static_cast<std::size_t>(nodes[k])]; };
    m_best_weights = weights_in(at(0), at(1), at(2), m_best.point_m);
  }
  return m_best;
}

DepthsAroundNodes SurfaceDepthMeter::measure_around_nodes(const Referee& referee, std::span<const RigidMotion> poses,
                                                          std::span<const Vec3> positions,
                                                          std::span<const Contact> truth, long budget) {
  const DeepestSurfacePoint kept = m_best;  // where the next `measure` starts
  assert(poses.size() == m_counting.size() && positions.size() == m_carriers.size());
  DepthsAroundNodes found{std::vector<double>(positions.size(), 0)};
  for (const Contact& contact : truth) {
    double& depth_m = found.depths_m[static_cast<std::size_t>(contact.node)];
    depth_m = std::max(depth_m, contact.depth_m);
  }
  m_work = 0;
  std::size_t first = 0;
  for (int bone = 0; bone < std::ssize(poses); ++bone) {
    first = take_depths(bone, truth, first);
    place_nodes(bone, referee, poses[static_cast<std::size_t>(bone)], positions);
    const RefereeTree& tree = referee.tree(bone);
    for (int index = 0; index < std::ssize(m_counting[static_cast<std::size_t>(bone)]); ++index) {
      const Triangle& nodes = m_triangles[static_cast<std::size_t>(
          m_counting[static_cast<std::size_t>(bone)][static_cast<std::size_t>(index)])];
      m_best = {};
      for (const int node : nodes) m_best.depth_m = std::max(m_best.depth_m, m_depth_m[static_cast<std::size_t>(node)]);
      m_parts.clear();
      Part part = whole_part(bone, index);
      part.bound_m = bound_from_nodes(nodes);
      part.whole = false;  // its cache is for `measure`
      if (part.bound_m > limit_m(tree)) {
        take_side_from_nodes(tree, nodes, part);
        push(part, tree);
        refine_parts(referee, budget);
        found.complete &= m_parts.empty() || m_parts.front().excess_m <= (1 + relative_tolerance) * m_best.depth_m;
      }
      for (const int node : nodes) {
        double& depth_m = found.depths_m[static_cast<std::size_t>(node)];
        depth_m = std::max(depth_m, m_best.depth_m);
      }
    }
  }
  m_parts.clear();
  m_best = kept;
  return found;
}

/// Depths of the nodes in this bone; `truth` is sorted by bone, and what it has of this one begins at `first`. Returns
/// where the next bone begins.
std::size_t SurfaceDepthMeter::take_depths(int bone, std::span<const Contact> truth, std::size_t first) {
  m_depth_m.assign(m_carriers.size(), 0);
  for (; first < truth.size() && truth[first].bone == bone; ++first) {
    m_depth_m[static_cast<std::size_t>(truth[first].node)] = truth[first].depth_m;
  }
  return first;
}

/// The deepest point is seldom far from where it was a frame ago, and a good start leaves out nearly all triangles.
void SurfaceDepthMeter::start_where_it_was_deepest(const Referee& referee, std::span<const RigidMotion> poses,
                                                   std::span<const Vec3> positions) {
  const DeepestSurfacePoint last = m_best;
  m_best = {};
  if (last.triangle < 0) return;
  const Triangle& nodes = m_triangles[static_cast<std::size_t>(last.triangle)];
  Vec3 point = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    point += m_best_weights[static_cast<Eigen::Index>(k)] * positions[static_cast<std::size_t>(nodes[k])];
  }
  m_best_rest_m = poses[static_cast<std::size_t>(last.bone)].apply_inverse(point);
  const SurfaceDistance surface = referee.closest(last.bone, m_best_rest_m, &m_work);
  if (surface.signed_distance_m >= 0) return;
  m_best = {-surface.signed_distance_m, 0, true, last.bone, last.triangle, point};
  m_best_out_of_bone = surface.normal;
}

/// In the bone's frame, with what is known of their distances.
void SurfaceDepthMeter::place_nodes(int bone, const Referee& referee, const RigidMotion& pose,
                                    std::span<const Vec3> positions) {
  const RefereeTree& tree = referee.tree(bone);
  m_rest.resize(positions.size());
  m_least_m.resize(positions.size());
  for (std::size_t node = 0; node < positions.size(); ++node) {
    const Vec3 rest_point = pose.apply_inverse(positions[node]);
    m_rest[node] = rest_point - tree.centre_m();
    if (m_carriers[node] >= 0) {
      m_least_m[node] = -std::numeric_limits<double>::infinity();
    } else if (m_depth_m[node] > 0) {
      m_least_m[node] = -m_depth_m[node];
    } else {
      m_least_m[node] = std::max(0.0, referee.least_distance(bone, static_cast<int>(node), rest_point));
    }
  }
}

/// Puts the triangles that may be deeper than the deepest point so far into the heap.
void SurfaceDepthMeter::collect_parts(int bone, const RefereeTree& tree) {
  const double rounding_m = depth_rounding * tree.diagonal_m();
  const std::vector<int>& counting = m_counting[static_cast<std::size_t>(bone)];
  for (std::size_t i = 0; i < counting.size(); ++i) {
    const Triangle& nodes = m_triangles[static_cast<std::size_t>(counting[i])];
    const double bound_m = bound_from_nodes(nodes);
    if (bound_m <= limit_m(tree)) continue;
    Part part = whole_part(bone, static_cast<int>(i));
    const TriangleCache& cache = m_caches[static_cast<std::size_t>(bone)][i];
    part.bound_m = cache.slot < 0 ? bound_m : std::min(bound_m, bound_from_cache(part, cache, rounding_m));
    take_side_from_nodes(tree, nodes, part);
    push(part, tree);
  }
}

/// A triangle that counts against the bone, with the slot that was nearest last.
SurfaceDepthMeter::Part SurfaceDepthMeter::whole_part(int bone, int index) const {
  const auto of_bone = static_cast<std::size_t>(bone), at = static_cast<std::size_t>(index);
  const Triangle& nodes = m_triangles[static_cast<std::size_t>(m_counting[of_bone][at])];
  Part part{m_rest[static_cast<std::size_t>(nodes[0])], m_rest[static_cast<std::size_t>(nodes[1])],
            m_rest[static_cast<std::size_t>(nodes[2])]};
  part.bone = bone;
  part.index = index;
  part.slot = m_caches[of_bone][at].slot;
  return part;
}

/// The most urgent first, until none may be deeper than the deepest point by more than the tolerance.
void SurfaceDepthMeter::refine_parts(const Referee& referee, long budget) {
  while (!m_parts.empty() && m_parts.front().excess_m > (1 + relative_tolerance) * m_best.depth_m && m_work < budget) {
    std::pop_heap(m_parts.begin(), m_parts.end(), less_urgent);
    const Part part = m_parts.back();
    m_parts.pop_back();
    refine(part, referee.tree(part.bone));
  }
}

/// The side of a free node is known from the truth, but where the surface is open, not the movement for which it holds.
void SurfaceDepthMeter::take_side_from_nodes(const RefereeTree& tree, const Triangle& nodes, Part& part) const {
  for (std::size_t k = 0; k < 3 && tree.closed() && part.known_steady_m == 0; ++k) {
    const auto node = static_cast<std::size_t>(nodes[k]);
    if (m_carriers[node] >= 0) continue;
    part.known_m = m_rest[node];
    part.known_inside = m_depth_m[node] > 0;
    part.known_steady_m = std::numeric_limits<double>::infinity();
  }
}

void SurfaceDepthMeter::push(Part part, const RefereeTree& tree) {
  if (part.bound_m <= limit_m(tree)) return;
  part.excess_m = part.bound_m - absolute_tolerance * tree.diagonal_m();
  m_parts.push_back(part);
  std::push_heap(m_parts.begin(), m_parts.end(), less_urgent);
}

double SurfaceDepthMeter::bound_from_cache(const Part& part, const TriangleCache& cache, double rounding_m) const {
  const Vec3 centroid = (part.a + part.b + part.c) / 3;
  const double moved = (centroid - cache.point_m).norm();
  return radius_about(centroid, part.a, part.b, part.c) + moved - cache.signed_distance_m + rounding_m;
}

/// Upper bound of the depth anywhere in the triangle (reports/performance/surface_depth.md).
double SurfaceDepthMeter::bound_from_nodes(const Triangle& triangle) const {
  const auto node = [&](std::size_t k) { return static_cast<std::size_t>(triangle[k]); };
  const Vec3& a = m_rest[node(0)];
  const Vec3& b = m_rest[node(1)];
  const Vec3& c = m_rest[node(2)];
  const double longest = longest_edge(a, b, c) * (1 + depth_rounding);
  const double least = std::min({m_least_m[node(0)], m_least_m[node(1)], m_least_m[node(2)]});
  const double most = std::max({m_least_m[node(0)], m_least_m[node(1)], m_least_m[node(2)]});
  return std::min(longest * std::numbers::inv_sqrt3 - least, longest - most);
}

/// Queries the part's centroid, and splits the part where that does not bound it.
void SurfaceDepthMeter::refine(const Part& part, const RefereeTree& tree) {
  const double rounding_m = depth_rounding * tree.diagonal_m();
  const Vec3 centroid = (part.a + part.b + part.c) / 3;
  const ClosestSurfacePoint nearest = tree.closest(centroid, part.slot, &m_work);
  const double distance = std::sqrt(nearest.squared_distance_m2);
  const double from_known = (centroid - part.known_m).norm() + rounding_m;
  Part facts;  // common to the parts that it is split into
  facts.known_m = centroid;
  if (from_known < std::min(distance, part.known_steady_m)) {
    facts.known_inside = part.known_inside;
    facts.known_steady_m = part.known_steady_m - from_known;
  } else {
    const SurfaceWinding winding = tree.winding(centroid, &m_work);
    facts.known_inside = distance > 0 && winding.number > 0.5;
    facts.known_steady_m = winding.steady_m;
  }
  const double signed_distance = facts.known_inside ? -distance : distance;
  const auto bone = static_cast<std::size_t>(part.bone);
  const auto index = static_cast<std::size_t>(part.index);
  if (part.whole) m_caches[bone][index] = {centroid, signed_distance, nearest.slot};

  const Vec3 out_of_bone =
      distance > rounding_m ? Vec3((centroid - nearest.point_m) / signed_distance) : tree.face_normal(nearest.slot);
  if (-signed_distance > m_best.depth_m) {
    m_best.depth_m = -signed_distance;
    m_best.bone = part.bone;
    m_best.triangle = m_counting[bone][index];
    m_best_rest_m = centroid + tree.centre_m();
    m_best_out_of_bone = out_of_bone;
  }
  const double radius = radius_about(centroid, part.a, part.b, part.c);
  if (radius - signed_distance + rounding_m <= limit_m(tree)) return;

  if (clear_when_moved(tree, part, out_of_bone, limit_m(tree))) return;
  // Parts along the same ridge or groove usually separate in the direction of the current maximum: try it.
  if (part.bone == m_best.bone && clear_when_moved(tree, part, m_best_out_of_bone, limit_m(tree))) return;
  const Vec3 into_muscle = (part.c - part.a).cross(part.b - part.a).stableNormalized();
  if (clear_when_moved(tree, part, into_muscle, limit_m(tree))) return;

  facts.whole = false;
  facts.bone = part.bone;
  facts.index = part.index;
  facts.slot = nearest.slot;
  split(part, tree, facts, signed_distance);
}

/// `facts`: common to the new parts; `signed_distance_m`: of the point `facts.known_m`.
void SurfaceDepthMeter::split(const Part& part, const RefereeTree& tree, const Part& facts, double signed_distance_m) {
  const double rounding_m = depth_rounding * tree.diagonal_m();
  const Vec3 ab = 0.5 * (part.a + part.b);
  const Vec3 bc = 0.5 * (part.b + part.c);
  const Vec3 ca = 0.5 * (part.c + part.a);
  for (const std::array<Vec3, 3>& corners :
       {std::array{ab, bc, ca}, std::array{part.a, ab, ca}, std::array{ab, part.b, bc}, std::array{ca, bc, part.c}}) {
    Part child = facts;
    child.a = corners[0];
    child.b = corners[1];
    child.c = corners[2];
    const double radius = radius_about(facts.known_m, child.a, child.b, child.c);
    child.bound_m = std::min(part.bound_m, radius - signed_distance_m + rounding_m);
    push(child, tree);
  }
}

/// Whether the part lies outside the bone once it is moved by `distance_m`, in `direction` (unit) or in one near it: in
/// a groove the direction out of one flank may lead into the other, and the sum of their normals out of both.
bool SurfaceDepthMeter::clear_when_moved(const RefereeTree& tree, const Part& part, Vec3 direction, double distance_m) {
  constexpr int attempts = 3;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    const Vec3 move = distance_m * direction;
    const int touched = tree.find_touched(part.a + move, part.b + move, part.c + move, &m_work);
    if (touched < 0) return tree.winding_number((part.a + part.b + part.c) / 3 + move, &m_work) < 0.5;
    direction = (direction + tree.face_normal(touched)).stableNormalized();
  }
  return false;
}

std::size_t SurfaceDepthMeter::bytes() const {
  std::size_t sum = m_triangles.capacity() * sizeof(Triangle) + m_carriers.capacity() * sizeof(int) +
                    m_rest.capacity() * sizeof(Vec3) + (m_least_m.capacity() + m_depth_m.capacity()) * sizeof(double) +
                    m_parts.capacity() * sizeof(Part);
  for (const std::vector<int>& counting : m_counting) sum += counting.capacity() * sizeof(int);
  for (const std::vector<TriangleCache>& caches : m_caches) sum += caches.capacity() * sizeof(TriangleCache);
  return sum;
}

}  // namespace musclebench
