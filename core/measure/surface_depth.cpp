#include "core/measure/surface_depth.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace musclebench {
namespace {

/// Rounding errors of a distance or a movement stay far below this share of the lengths that they come from.
constexpr double rounding_share = 0x1p-40;

double longest_edge(const Vec3& a, const Vec3& b, const Vec3& c) {
  return std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
}

Vec3 weights_in(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& point) {
  const Vec3 normal = (b - a).cross(c - a);
  const double whole = normal.squaredNorm();
  if (!(whole > 0)) return Vec3::Constant(1.0 / 3);
  const double weight_b = (point - a).cross(c - a).dot(normal) / whole;
  const double weight_c = (b - a).cross(point - a).dot(normal) / whole;
  return {1 - weight_b - weight_c, weight_b, weight_c};
}

}  // namespace

SurfaceDepthMeter::SurfaceDepthMeter(std::span<const Triangle> triangles, std::span<const int> carriers, int bones)
    : m_triangles(triangles.begin(), triangles.end()),
      m_counting(static_cast<std::size_t>(bones)),
      m_memories(static_cast<std::size_t>(bones)),
      m_carriers(carriers.begin(), carriers.end()) {
  const auto carrier = [&](int node) { return m_carriers[static_cast<std::size_t>(node)]; };
  for (int bone = 0; bone < bones; ++bone) {
    std::vector<int>& counting = m_counting[static_cast<std::size_t>(bone)];
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const Triangle& nodes = triangles[t];
      const bool some_free = std::any_of(nodes.begin(), nodes.end(), [&](int node) { return carrier(node) < 0; });
      const bool carried = std::any_of(nodes.begin(), nodes.end(), [&](int node) { return carrier(node) == bone; });
      if (some_free && !carried) counting.push_back(static_cast<int>(t));
    }
    m_memories[static_cast<std::size_t>(bone)].resize(counting.size());
  }
}

double SurfaceDepthMeter::limit_m(const RefereeTree& tree) const {
  return (1 + relative_tolerance) * m_best.depth_m + absolute_tolerance * tree.diagonal_m();
}

DeepestSurfacePoint SurfaceDepthMeter::measure(const Referee& referee, std::span<const RigidMotion> poses,
                                               std::span<const Vec3> positions, std::span<const Contact> truth) {
  assert(poses.size() == m_counting.size() && positions.size() == m_carriers.size());
  m_queries = 0;
  start_where_it_was_deepest(referee, poses, positions);
  for (const Contact& contact : truth) {
    if (contact.depth_m > m_best.depth_m) {
      m_best = {contact.depth_m, contact.bone, -1, positions[static_cast<std::size_t>(contact.node)]};
    }
  }
  std::size_t first = 0;
  for (std::size_t bone = 0; bone < poses.size(); ++bone) {
    m_inside.assign(positions.size(), 0);
    for (; first < truth.size() && truth[first].bone == static_cast<int>(bone); ++first) {
      m_inside[static_cast<std::size_t>(truth[first].node)] = 1;
    }
    measure_bone(static_cast<int>(bone), referee, poses[bone], positions);
  }
  if (m_best.triangle >= 0) m_best.point_m = poses[static_cast<std::size_t>(m_best.bone)].apply(m_best_rest_m);
  return m_best;
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
  const double depth_m = -referee.signed_distance(last.bone, m_best_rest_m);
  if (depth_m > 0) m_best = {depth_m, last.bone, last.triangle, point};
}

void SurfaceDepthMeter::measure_bone(int bone, const Referee& referee, const RigidMotion& pose,
                                     std::span<const Vec3> positions) {
  const RefereeTree& tree = referee.tree(bone);
  m_rest.resize(positions.size());
  m_least_m.resize(positions.size());
  for (std::size_t node = 0; node < positions.size(); ++node) {
    const Vec3 rest_point = pose.apply_inverse(positions[node]);
    m_rest[node] = rest_point - tree.centre_m();
    const bool known = m_carriers[node] < 0 && m_inside[node] == 0;
    m_least_m[node] = known ? std::max(0.0, referee.least_distance(bone, static_cast<int>(node), rest_point))
                            : -std::numeric_limits<double>::infinity();
  }

  const double rounding_m = rounding_share * tree.diagonal_m();
  const std::vector<int>& counting = m_counting[static_cast<std::size_t>(bone)];
  for (std::size_t i = 0; i < counting.size(); ++i) {
    const Triangle& nodes = m_triangles[static_cast<std::size_t>(counting[i])];
    if (bound_from_nodes(nodes) <= limit_m(tree)) continue;
    const auto at = [&](std::size_t k) -> const Vec3& { return m_rest[static_cast<std::size_t>(nodes[k])]; };
    Part part{at(0), at(1), at(2), Vec3::Zero()};
    Memory& memory = m_memories[static_cast<std::size_t>(bone)][i];
    if (memory.place >= 0) {
      const Vec3 centroid = (part.a + part.b + part.c) / 3;
      const double radius = std::sqrt(std::max(
          {(part.a - centroid).squaredNorm(), (part.b - centroid).squaredNorm(), (part.c - centroid).squaredNorm()}));
      const double moved = (centroid - memory.point_m).norm();
      if (radius + moved - memory.signed_distance_m + rounding_m <= limit_m(tree)) continue;
      part.place = memory.place;
    }
    for (std::size_t k = 0; k < 3 && !part.known; ++k) {
      const auto node = static_cast<std::size_t>(nodes[k]);
      part.known = m_carriers[node] < 0;
      part.known_m = at(k);
      part.known_inside = m_inside[node] != 0;
    }
    search(tree, bone, counting[i], part, memory);
  }
}

/// Upper bound of the depth anywhere in the triangle: no point is farther from the nearest corner than the longest edge
/// over sqrt(3), nor farther from one corner than that corner's longer edge.
double SurfaceDepthMeter::bound_from_nodes(const Triangle& triangle) const {
  const auto place = [&](std::size_t k) { return static_cast<std::size_t>(triangle[k]); };
  const Vec3& a = m_rest[place(0)];
  const Vec3& b = m_rest[place(1)];
  const Vec3& c = m_rest[place(2)];
  const double longest = longest_edge(a, b, c) * (1 + rounding_share);
  const double least = std::min({m_least_m[place(0)], m_least_m[place(1)], m_least_m[place(2)]});
  const double most = std::max({m_least_m[place(0)], m_least_m[place(1)], m_least_m[place(2)]});
  return std::min(longest * std::numbers::inv_sqrt3 - least, longest - most);
}

void SurfaceDepthMeter::search(const RefereeTree& tree, int bone, int triangle, const Part& whole, Memory& memory) {
  const double rounding_m = rounding_share * tree.diagonal_m();
  const Vec3 out_of_muscle = (whole.b - whole.a).cross(whole.c - whole.a).stableNormalized();
  bool first = true;
  m_parts.assign(1, whole);
  while (!m_parts.empty()) {
    const Part part = m_parts.back();
    m_parts.pop_back();
    const Vec3 centroid = (part.a + part.b + part.c) / 3;
    const double radius = std::sqrt(std::max(
        {(part.a - centroid).squaredNorm(), (part.b - centroid).squaredNorm(), (part.c - centroid).squaredNorm()}));
    ++m_queries;
    const ClosestSurfacePoint nearest = tree.closest(centroid, part.place);
    const double distance = std::sqrt(nearest.squared_distance_m2);
    const bool near_known = tree.closed() && part.known && (centroid - part.known_m).norm() < distance - rounding_m;
    const bool inside = near_known ? part.known_inside : distance > 0 && tree.winding_number(centroid) > 0.5;
    const double signed_distance = inside ? -distance : distance;
    if (first) memory = {centroid, signed_distance, nearest.place};
    first = false;

    if (-signed_distance > m_best.depth_m) {
      m_best.depth_m = -signed_distance;
      m_best.bone = bone;
      m_best.triangle = triangle;
      m_best_rest_m = centroid + tree.centre_m();
      m_best_weights = weights_in(whole.a, whole.b, whole.c, centroid);
    }
    if (radius - signed_distance + rounding_m <= limit_m(tree)) continue;

    const Vec3 way =
        distance > rounding_m ? Vec3((centroid - nearest.point_m) / signed_distance) : tree.face_normal(nearest.place);
    if (clear_when_moved(tree, part, way, limit_m(tree))) continue;
    if (clear_when_moved(tree, part, -out_of_muscle, limit_m(tree))) continue;

    const Vec3 ab = 0.5 * (part.a + part.b);
    const Vec3 bc = 0.5 * (part.b + part.c);
    const Vec3 ca = 0.5 * (part.c + part.a);
    Part child{ab, bc, ca, centroid, true, inside, nearest.place};
    m_parts.push_back(child);
    for (const std::array<Vec3, 3>& corners :
         {std::array{part.a, ab, ca}, std::array{ab, part.b, bc}, std::array{ca, bc, part.c}}) {
      child.a = corners[0];
      child.b = corners[1];
      child.c = corners[2];
      m_parts.push_back(child);
    }
  }
}

/// Whether the part lies outside the bone once it is moved by `way_m` along the unit vector `way`.
bool SurfaceDepthMeter::clear_when_moved(const RefereeTree& tree, const Part& part, const Vec3& way, double way_m) {
  ++m_queries;
  const Vec3 move = way_m * way;
  if (tree.meets(part.a + move, part.b + move, part.c + move)) return false;
  return tree.winding_number((part.a + part.b + part.c) / 3 + move) < 0.5;
}

std::size_t SurfaceDepthMeter::bytes() const {
  std::size_t sum = m_triangles.capacity() * sizeof(Triangle) + m_carriers.capacity() * sizeof(int) +
                    m_rest.capacity() * sizeof(Vec3) + m_least_m.capacity() * sizeof(double) + m_inside.capacity() +
                    m_parts.capacity() * sizeof(Part);
  for (const std::vector<int>& counting : m_counting) sum += counting.capacity() * sizeof(int);
  for (const std::vector<Memory>& memories : m_memories) sum += memories.capacity() * sizeof(Memory);
  return sum;
}

}  // namespace musclebench
