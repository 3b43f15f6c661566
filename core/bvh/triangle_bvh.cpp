#include "core/bvh/triangle_bvh.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/prefetch.hpp"
#include "core/bvh/triangle_bvh_builder.hpp"
#include "core/bvh/triangle_bvh_search.hpp"

namespace musclebench {

namespace {

/// Relative rounding errors of single and double precision.
constexpr double float_rounding = 0x1p-24;
constexpr double double_rounding = 0x1p-53;
/// More than the relative rounding error of distances that are compared.
constexpr double distance_rounding = 1e-12;
/// Unused slots of leaves are farther away than this.
constexpr float widest_limit = 0.5F * bvh_far_away * bvh_far_away;

}  // namespace

void TriangleBvh::Search::consider(int triangle_index) {
  const ClosestOnTriangle found = tree->closest_on(exact_point, triangle_index);
  if (found.squared_distance_m2 < best.squared_distance_m2 || (found.squared_distance_m2 == best.squared_distance_m2 &&
                                                               (best_triangle < 0 || triangle_index < best_triangle))) {
    best = found;
    best_triangle = triangle_index;
  }
}

void TriangleBvh::Search::decide_candidates() {
  for (std::size_t i = 0; i < count; ++i) {
    if (squared[i] <= limit) {
      consider(triangle[i]);
    }
  }
  count = 0;
}

void TriangleBvh::Search::lower_limit(double distance_m) {
  const double reach = distance_m * tree->m_scale + slack;
  limit = std::min(limit, static_cast<float>(std::min<double>(reach * reach * 1.000001, widest_limit)));
}

ClosestPoint TriangleBvh::Search::answer() const {
  return {best.point, std::sqrt(best.squared_distance_m2), best_triangle, best.feature};
}

TriangleBvh::TriangleBvh(const TriangleMesh& mesh) {
  if (!mesh.triangles.empty()) {
    TriangleBvhBuilder(mesh, *this).build();
  }
}

TriangleBvh::TriangleBvh(TriangleBvh&& other) noexcept = default;
TriangleBvh& TriangleBvh::operator=(TriangleBvh&& other) noexcept = default;
TriangleBvh::~TriangleBvh() = default;

void TriangleBvh::prefetch_leaves(const CandidateLeaves& list) const {
  constexpr std::size_t count = 4;
  for (std::size_t i = 0; i < count && list.leaf[i] >= 0; ++i) {
    prefetch(m_leaves[static_cast<std::size_t>(list.leaf[i])]);
  }
}

bool TriangleBvh::is_sliver(int triangle) const {
  const BvhLeaf& leaf = m_leaves[static_cast<std::size_t>(m_leaf_of[static_cast<std::size_t>(triangle)])];
  return (leaf.slivers >> leaf.lane_of(triangle) & 1U) != 0;
}

float TriangleBvh::slack_for(double reach, double coordinate) const {
  return static_cast<float>(float_rounding * (49 * (1 + reach) + 17 * m_longest_side) +
                            32 * double_rounding * std::max(m_reach, coordinate));
}

float TriangleBvh::near_slack_for(double reach, double coordinate) const {
  return static_cast<float>(float_rounding * (2 * (1 + reach) + 44 * m_longest_side) +
                            32 * double_rounding * std::max(m_reach, coordinate));
}

void TriangleBvh::prepare(const Vec3& point, Search& search) const {
  search.count = 0;
  search.least = bvh_far_away * bvh_far_away;
  search.first_leaf = -1;
  search.best_triangle = -1;
  search.nodes = m_nodes.data();
  search.leaves = m_leaves.data();
  search.corners = m_corners.data();
  search.tree = this;
  search.exact_point = point;
  search.best.squared_distance_m2 = std::numeric_limits<double>::infinity();
  search.limit = widest_limit;
  const Vec3 local = m_scale * (point - m_centre_m);
  const double reach = local.cwiseAbs().maxCoeff();
  search.slack = slack_for(reach, m_scale * point.cwiseAbs().maxCoeff());
  search.point = {static_cast<float>(local.x()), static_cast<float>(local.y()), static_cast<float>(local.z())};
  search.decide = [](BvhSearch& self) {
    auto& full = static_cast<Search&>(self);
    full.decide_candidates();
    full.lower_limit(std::sqrt(full.best.squared_distance_m2));
  };
}

TriangleBvh::Search TriangleBvh::search_for(const Vec3& point) const {
  Search search;
  prepare(point, search);
  return search;
}

bool TriangleBvh::within_horizon(const Vec3& point) const {
  // A comparison that a NaN fails.
  return (m_scale * (point - m_centre_m).array().abs() <= bvh_horizon).all();
}

void TriangleBvh::search_all(Search& search) const {
  for (int triangle = 0; triangle < static_cast<int>(m_corners.size()); ++triangle) {
    search.consider(triangle);
  }
}

std::optional<ClosestPoint> TriangleBvh::closest_point(const Vec3& point, double max_distance_m) const {
  if (m_corners.empty() || !(max_distance_m >= 0)) {
    return std::nullopt;
  }
  Search search = search_for(point);
  // Finite, so that no triangle is closer to a NaN.
  search.best.squared_distance_m2 = std::min(max_distance_m * max_distance_m, std::numeric_limits<double>::max());
  search.lower_limit(max_distance_m);
  if (within_horizon(point)) {
    search_closest(search);
    search.decide_candidates();
  } else {
    search_all(search);
  }
  return search.best_triangle < 0 ? std::nullopt : std::optional(search.answer());
}

ClosestPoint TriangleBvh::closest_point_from(const Vec3& point, int triangle) const {
  Search search = search_for(point);
  if (within_horizon(point)) {
    search.first_leaf = m_leaf_of[static_cast<std::size_t>(triangle)];
    search_closest(search);
    search.decide_candidates();
  } else {
    search.best = closest_on(point, triangle);
    search.best_triangle = triangle;
    if (point.allFinite()) {
      search_all(search);
    }
  }
  return search.answer();
}

void TriangleBvh::list_candidate_leaves(const Vec3& point, double radius_m, CandidateLeaves& list) const {
  list.clear();
  if (m_corners.empty() || !within_horizon(point)) {
    return;
  }
  Search search = search_for(point);
  search.lower_limit(radius_m);
  const NearestLeaves near = search_leaves(search);
  list.point = search.point;
  list.cutoff = bvh_round_down(std::max(std::sqrt(static_cast<double>(near.cutoff)) - search.slack, 0.0));
  list.leaf.fill(-1);
  for (std::size_t i = 0; i < near.count; ++i) {
    list.leaf[i] = near.leaf[i];
    const double distance = std::sqrt(static_cast<double>(near.squared[i])) - search.slack;
    list.distance[i] =
        list.cutoff > 0
            ? static_cast<std::uint8_t>(std::clamp(distance / list.cutoff, 0.0, 1.0) * CandidateLeaves::distance_steps)
            : std::uint8_t{0};
  }
}

Clearance TriangleBvh::clearance_from(const Vec3& point, int triangle) const {
  constexpr float squared_fraction = 0.81F;
  if (!within_horizon(point)) {
    return {0, triangle};
  }
  Search search = search_for(point);
  search.first_leaf = m_leaf_of[static_cast<std::size_t>(triangle)];
  const DistanceBound bound = search_bound(search, squared_fraction);
  return {std::max(std::sqrt(static_cast<double>(bound.squared)) - search.slack, 0.0) / m_scale, bound.triangle};
}

void TriangleBvh::begin_candidate_search(const Vec3& point, const CandidateLeaves& list, Search& search) const {
  prepare(point, search);
  if (!within_horizon(point)) {
    search.moved = std::numeric_limits<float>::infinity();
    return;
  }
  double squared = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double difference = static_cast<double>(search.point[axis]) - static_cast<double>(list.point[axis]);
    squared += difference * difference;
  }
  // An upper bound: both points are rounded, by less than the slack in all.
  search.moved = static_cast<float>(std::sqrt(squared) * (1 + 16 * float_rounding)) + search.slack;
  search_listed(search, list, (search.moved + search.slack) * (1 + 2 * static_cast<float>(float_rounding)));
  const float known = std::max(list.cutoff - search.moved, 0.0F);
  if (search.least >= known * known) {  // the list is not enough: a search of the tree will follow
    prefetch_ancestors(list);
  }
}

void TriangleBvh::prefetch_ancestors(const CandidateLeaves& list) const {
  for (const std::int32_t ancestor : m_leaves[static_cast<std::size_t>(list.leaf[0])].ancestors) {
    if (ancestor < 0) {
      return;
    }
    prefetch(m_nodes[static_cast<std::size_t>(ancestor)]);
  }
}

ClosestCandidate TriangleBvh::finish_candidate_search(Search& search, const CandidateLeaves& list,
                                                      double enough_m) const {
  // Triangles of the listed leaves that were skipped are beyond the limit, which is no smaller.
  const double least = std::sqrt(static_cast<double>(search.least)) - search.slack;
  const double unlisted_m = (static_cast<double>(list.cutoff) - static_cast<double>(search.moved)) / m_scale;
  const double clearance_m = std::min(least / m_scale, unlisted_m);
  if (clearance_m > enough_m) {
    return {{}, false, clearance_m};
  }
  search.decide_candidates();
  const ClosestPoint closest = search.answer();
  return {closest, closest.distance_m * (1 + distance_rounding) < unlisted_m};
}

std::size_t TriangleBvh::bytes() const {
  return m_nodes.capacity() * sizeof(BvhNode) + m_leaves.capacity() * sizeof(BvhLeaf) +
         m_clusters.capacity() * sizeof(m_clusters[0]) + m_corners.capacity() * sizeof(m_corners[0]) +
         m_leaf_of.capacity() * sizeof(int);
}

}  // namespace musclebench
