#include "core/bvh/triangle_tree.hpp"

#include <algorithm>
#include <cmath>

#include "core/bvh/triangle_tree_builder.hpp"
#include "core/bvh/triangle_tree_search.hpp"

namespace musclebench {

namespace {

/// Half a unit in the last place of a float and of a double, relative.
constexpr double float_rounding = 0x1p-24;
constexpr double double_rounding = 0x1p-53;
/// Above the rounding of distances that are compared.
constexpr double distance_rounding = 1e-12;
/// The unused places of leaves are farther than that.
constexpr float widest_limit = 0.5F * tree_nowhere * tree_nowhere;

float round_down(double value) {
  const auto rounded = static_cast<float>(value);
  return rounded > value ? std::nextafter(rounded, -std::numeric_limits<float>::infinity()) : rounded;
}

}  // namespace

void TriangleTree::Search::offer(int index) {
  const ClosestOnTriangle found = tree->closest_on(exact_point, index);
  if (found.squared_distance_m2 < best.squared_distance_m2 ||
      (found.squared_distance_m2 == best.squared_distance_m2 && (best_triangle < 0 || index < best_triangle))) {
    best = found;
    best_triangle = index;
  }
}

void TriangleTree::Search::decide_listed() {
  for (std::size_t i = 0; i < count; ++i) {
    if (squared[i] <= limit) {
      offer(triangle[i]);
    }
  }
  count = 0;
}

void TriangleTree::Search::narrow(double distance_m) {
  const double reach = distance_m * tree->m_scale + slack;
  limit = std::min(limit, static_cast<float>(std::min<double>(reach * reach * 1.000001, widest_limit)));
}

ClosestPoint TriangleTree::Search::answer() const {
  return {best.point, std::sqrt(best.squared_distance_m2), best_triangle, best.feature};
}

TriangleTree::TriangleTree(const TriangleMesh& mesh) {
  if (!mesh.triangles.empty()) {
    TriangleTreeBuilder(mesh, *this).build();
  }
}

bool TriangleTree::is_needle(int triangle) const {
  const TreeLeaf& leaf = m_leaves[static_cast<std::size_t>(m_leaf_of[static_cast<std::size_t>(triangle)])];
  return (leaf.needles >> leaf.place_of(triangle) & 1U) != 0;
}

float TriangleTree::slack_for(double reach, double coordinate) const {
  return static_cast<float>(float_rounding * (49 * (1 + reach) + 17 * m_longest_side) +
                            32 * double_rounding * std::max(m_reach, coordinate));
}

float TriangleTree::near_slack_for(double reach, double coordinate) const {
  return static_cast<float>(float_rounding * (2 * (1 + reach) + 44 * m_longest_side) +
                            32 * double_rounding * std::max(m_reach, coordinate));
}

void TriangleTree::prepare(const Vec3& point, Search& search) const {
  search.count = 0;
  search.least = tree_nowhere * tree_nowhere;
  search.first_leaf = -1;
  search.best_triangle = -1;
  search.nodes = m_nodes.data();
  search.leaves = m_leaves.data();
  search.corners = m_corners.data();
  search.tree = this;
  search.exact_point = point;
  search.best.squared_distance_m2 = std::numeric_limits<double>::infinity();
  search.limit = widest_limit;
  const Vec3 own = m_scale * (point - m_centre_m);
  const double reach = own.cwiseAbs().maxCoeff();
  search.slack = slack_for(reach, m_scale * point.cwiseAbs().maxCoeff());
  search.point = {static_cast<float>(own.x()), static_cast<float>(own.y()), static_cast<float>(own.z())};
  search.decide = [](TreeSearch& self) {
    auto& full = static_cast<Search&>(self);
    full.decide_listed();
    full.narrow(std::sqrt(full.best.squared_distance_m2));
  };
}

TriangleTree::Search TriangleTree::search_for(const Vec3& point) const {
  Search search;
  prepare(point, search);
  return search;
}

bool TriangleTree::within_horizon(const Vec3& point) const {
  // Written so that what is not a number is not.
  return (m_scale * (point - m_centre_m).array().abs() <= tree_horizon).all();
}

void TriangleTree::search_all(Search& search) const {
  for (int triangle = 0; triangle < static_cast<int>(m_corners.size()); ++triangle) {
    search.offer(triangle);
  }
}

std::optional<ClosestPoint> TriangleTree::closest_point(const Vec3& point, double max_distance_m) const {
  if (m_corners.empty() || !(max_distance_m >= 0)) {
    return std::nullopt;
  }
  Search search = search_for(point);
  // Finite, so that a point that is not a number is close to nothing.
  search.best.squared_distance_m2 = std::min(max_distance_m * max_distance_m, std::numeric_limits<double>::max());
  search.narrow(max_distance_m);
  if (within_horizon(point)) {
    search_closest(search);
    search.decide_listed();
  } else {
    search_all(search);
  }
  return search.best_triangle < 0 ? std::nullopt : std::optional(search.answer());
}

ClosestPoint TriangleTree::closest_point_from(const Vec3& point, int triangle) const {
  Search search = search_for(point);
  if (within_horizon(point)) {
    search.first_leaf = m_leaf_of[static_cast<std::size_t>(triangle)];
    search_closest(search);
    search.decide_listed();
  } else {
    search.best = closest_on(point, triangle);
    search.best_triangle = triangle;
    if (point.allFinite()) {
      search_all(search);
    }
  }
  return search.answer();
}

void TriangleTree::list_leaves(const Vec3& point, double radius_m, NearLeaves& list) const {
  list.clear();
  if (m_corners.empty() || !within_horizon(point)) {
    return;
  }
  Search search = search_for(point);
  search.narrow(radius_m);
  const NearestLeaves near = search_leaves(search);
  list.place = search.point;
  list.complete = round_down(std::max(std::sqrt(static_cast<double>(near.others)) - search.slack, 0.0));
  list.leaf.fill(-1);
  for (std::size_t i = 0; i < near.count; ++i) {
    list.leaf[i] = near.leaf[i];
    const double distance = std::sqrt(static_cast<double>(near.squared[i])) - search.slack;
    list.distance[i] =
        list.complete > 0
            ? static_cast<std::uint8_t>(std::clamp(distance / list.complete, 0.0, 1.0) * NearLeaves::steps)
            : std::uint8_t{0};
  }
}

Clearance TriangleTree::clearance_from(const Vec3& point, int triangle) const {
  constexpr float squared_share = 0.81F;
  if (!within_horizon(point)) {
    return {0, triangle};
  }
  Search search = search_for(point);
  search.first_leaf = m_leaf_of[static_cast<std::size_t>(triangle)];
  const DistanceBound bound = search_bound(search, squared_share);
  return {std::max(std::sqrt(static_cast<double>(bound.squared)) - search.slack, 0.0) / m_scale, bound.triangle};
}

void TriangleTree::start_listed(const Vec3& point, const NearLeaves& list, Search& search) const {
  prepare(point, search);
  if (!within_horizon(point)) {
    search.moved = std::numeric_limits<float>::infinity();
    return;
  }
  double squared = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double way = static_cast<double>(search.point[axis]) - static_cast<double>(list.place[axis]);
    squared += way * way;
  }
  // Both places are rounded: by less than the slack and some units of the way.
  search.moved = static_cast<float>(std::sqrt(squared) * (1 + 16 * float_rounding)) + search.slack;
  search_listed(search, list, (search.moved + search.slack) * (1 + 2 * static_cast<float>(float_rounding)));
  const float known = std::max(list.complete - search.moved, 0.0F);
  if (search.least >= known * known) {  // a search will follow
    fetch_way_to(list);
  }
}

ListedClosest TriangleTree::finish_listed(Search& search, const NearLeaves& list, double enough_m) const {
  // What was not looked at is beyond the limit, which is more.
  const double least = std::sqrt(static_cast<double>(search.least)) - search.slack;
  const double others_m = (static_cast<double>(list.complete) - static_cast<double>(search.moved)) / m_scale;
  const double clearance_m = std::min(least / m_scale, others_m);
  if (clearance_m > enough_m) {
    return {{}, false, clearance_m};
  }
  search.decide_listed();
  const ClosestPoint closest = search.answer();
  return {closest, closest.distance_m * (1 + distance_rounding) < others_m};
}

std::size_t TriangleTree::bytes() const {
  return m_nodes.capacity() * sizeof(TreeNode) + m_leaves.capacity() * sizeof(TreeLeaf) +
         m_clusters.capacity() * sizeof(m_clusters[0]) + m_corners.capacity() * sizeof(m_corners[0]) +
         m_leaf_of.capacity() * sizeof(int);
}

}  // namespace musclebench
