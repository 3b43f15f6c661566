#include "core/referee/referee.hpp"

#include <cassert>
#include <cmath>
#include <limits>

#include "core/base/input_error.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {
namespace {

/// Rounding errors of a distance, a movement or a direction stay far below this share of the lengths that they come
/// from. Of a bone's diagonal it is more than `touching_distance_m`, so that no side is cached of a point that
/// touches.
constexpr double rounding_share = 0x1p-39;

constexpr double no_limit = std::numeric_limits<double>::infinity();

bool stays_within(double moved_m, double clearance_m, double diagonal_m) {
  return moved_m < clearance_m * (1 - rounding_share) - rounding_share * diagonal_m;
}

SurfaceDistance describe(const RefereeTree& tree, const Vec3& point, const ClosestSurfacePoint& nearest, bool inside) {
  const double distance = std::sqrt(nearest.squared_distance_m2);
  const Vec3 outwards = inside ? Vec3(nearest.point_m - point) : Vec3(point - nearest.point_m);
  // So close to the surface the difference of the two points is mostly rounding.
  const bool direction_known = distance > rounding_share * tree.diagonal_m();
  return {inside ? -distance : distance, nearest.point_m,
          direction_known ? Vec3(outwards / distance) : tree.face_normal(nearest.slot)};
}

bool is_inside(const RefereeTree& tree, const Vec3& point, const ClosestSurfacePoint& nearest, long* work) {
  return nearest.squared_distance_m2 > 0 && tree.winding_number(point, work) > 0.5;
}

}  // namespace

Referee::Referee(std::span<const Bone> bones, int nodes, int threads, DistanceReuse reuse)
    : m_node_caches(bones.size()), m_threads(threads), m_reuses_distances(reuse == DistanceReuse::on) {
  assert(nodes >= 0 && threads >= 1);
  m_trees.reserve(bones.size());
  for (const Bone& bone : bones) {
    if (bone.surface.mesh.triangles.empty()) {
      throw InputError("bone " + bone.name, "its surface has no triangles; give a mesh with faces");
    }
    m_trees.emplace_back(bone.surface.mesh);
    m_touching_m.push_back(touching_distance_m(bone.surface.mesh));
  }
  for (std::vector<NodeCache>& caches : m_node_caches) caches.resize(static_cast<std::size_t>(nodes));
}

double Referee::signed_distance(int bone, const Vec3& rest_point) const {
  return closest(bone, rest_point).signed_distance_m;
}

SurfaceDistance Referee::closest(int bone, const Vec3& rest_point, long* work) const {
  const RefereeTree& tree = m_trees[static_cast<std::size_t>(bone)];
  const Vec3 point = rest_point - tree.centre_m();
  const ClosestSurfacePoint nearest = tree.closest(point, -1, work);
  SurfaceDistance answer = describe(tree, point, nearest, is_inside(tree, point, nearest, work));
  answer.closest_point_m += tree.centre_m();
  return answer;
}

double Referee::least_distance(int bone, int node, const Vec3& rest_point) const {
  const NodeCache& cache = m_node_caches[static_cast<std::size_t>(bone)][static_cast<std::size_t>(node)];
  const RefereeTree& bone_tree = tree(bone);
  const double moved = (rest_point - bone_tree.centre_m() - cache.point_m).norm();
  return cache.clearance_m * (1 - rounding_share) - moved - rounding_share * bone_tree.diagonal_m();
}

bool Referee::examine(int bone, const Vec3& point, NodeCache& cache, SurfaceDistance& found,
                      RefereeEffort& effort) const {
  const RefereeTree& tree = m_trees[static_cast<std::size_t>(bone)];
  const double moved = (point - cache.point_m).norm();
  bool side_known = m_reuses_distances && stays_within(moved, cache.clearance_m, tree.diagonal_m()) &&
                    stays_within(moved, cache.steady_m, tree.diagonal_m());
  if (side_known && !cache.inside) return false;
  if (!point.allFinite()) return false;

  const double box_distance = tree.box_distance(point);
  if (m_reuses_distances && tree.closed() && box_distance > 0) {
    cache = {point, box_distance, no_limit, -1, false};
    return false;
  }
  ++effort.distance_queries;
  const ClosestSurfacePoint nearest = tree.closest(point, m_reuses_distances ? cache.triangle : -1, &effort.work);
  const double distance = std::sqrt(nearest.squared_distance_m2);
  side_known =
      side_known || (m_reuses_distances && cache.clearance_m >= 0 && stays_within(moved, distance, tree.diagonal_m()) &&
                     stays_within(moved, cache.steady_m, tree.diagonal_m()));
  bool inside = cache.inside;
  double steady_m = cache.steady_m - moved;
  if (!side_known) {
    ++effort.winding_numbers;
    const SurfaceWinding winding = tree.winding(point, &effort.work);
    inside = distance > m_touching_m[static_cast<std::size_t>(bone)] && winding.number > 0.5;
    steady_m = winding.steady_m;
  }
  cache = {point, distance, steady_m, nearest.slot, inside};
  if (inside) found = describe(tree, point, nearest, inside);
  return inside;
}

void Referee::judge_bone(int bone, const RigidMotion& pose, std::span<const Vec3> positions,
                         std::span<const int> nodes) {
  const RefereeTree& tree = m_trees[static_cast<std::size_t>(bone)];
  std::vector<NodeCache>& caches = m_node_caches[static_cast<std::size_t>(bone)];
  const int count = static_cast<int>(nodes.size());
  long distance_queries = 0;
  long winding_numbers = 0;
  long work = 0;
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 128) num_threads(m_threads) if (m_threads > 1) \
    reduction(+ : distance_queries, winding_numbers, work)
#endif
  for (int i = 0; i < count; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const auto node = static_cast<std::size_t>(nodes[index]);
    const Vec3 point = pose.apply_inverse(positions[node]) - tree.centre_m();
    SurfaceDistance found;
    RefereeEffort effort;
    m_inside[index] = examine(bone, point, caches[node], found, effort) ? 1 : 0;
    if (m_inside[index] != 0) {
      m_found[index] = {nodes[index], bone, -found.signed_distance_m, pose.apply_to_direction(found.normal)};
    }
    distance_queries += effort.distance_queries;
    winding_numbers += effort.winding_numbers;
    work += effort.work;
  }
  m_effort.distance_queries += distance_queries;
  m_effort.winding_numbers += winding_numbers;
  m_effort.work += work;
}

void Referee::judge(std::span<const RigidMotion> poses, std::span<const Vec3> positions, std::span<const int> nodes,
                    std::vector<Contact>& truth) {
  assert(poses.size() == m_trees.size());
  truth.clear();
  m_effort = {};
  m_found.resize(nodes.size());
  m_inside.resize(nodes.size());
  for (std::size_t bone = 0; bone < m_trees.size(); ++bone) {
    judge_bone(static_cast<int>(bone), poses[bone], positions, nodes);
    for (std::size_t index = 0; index < nodes.size(); ++index) {
      if (m_inside[index] != 0) truth.push_back(m_found[index]);
    }
  }
}

std::size_t Referee::bytes() const {
  std::size_t sum = m_found.capacity() * sizeof(Contact) + m_inside.capacity();
  for (const RefereeTree& tree : m_trees) sum += tree.bytes();
  for (const std::vector<NodeCache>& caches : m_node_caches) sum += caches.capacity() * sizeof(NodeCache);
  return sum;
}

}  // namespace musclebench
