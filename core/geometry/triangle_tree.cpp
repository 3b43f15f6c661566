#include "core/geometry/triangle_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

namespace musclebench {

namespace {

constexpr int bin_count = 16;
/// Beyond this depth ranges are halved by count, which bounds the depth of the tree, and so of the stacks, for any
/// mesh.
constexpr int deepest_by_area = 24;
constexpr int stack_capacity = 256;
/// Relative rounding error of a dot product, generously.
constexpr double rounding = 1e-14;
/// Closed surfaces have whole winding numbers; one this close to 0.5 shows that the dipoles were too coarse.
constexpr double safe_margin = 0.25;

struct Box {
  Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 upper = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void extend(const Vec3& point) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
  }
  void extend(const Box& other) {
    lower = lower.cwiseMin(other.lower);
    upper = upper.cwiseMax(other.upper);
  }
  [[nodiscard]] double half_area() const {
    const Vec3 size = (upper - lower).cwiseMax(0.0);
    return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
  }
};

struct Range {
  int begin = 0;
  int end = 0;
  [[nodiscard]] int count() const { return end - begin; }
};

using Lane = Eigen::Array4d;
using ConstLane = Eigen::Map<const Lane>;

ConstLane lane(const std::array<double, 4>& values) { return ConstLane(values.data()); }

// The compiler's own measure finds these too large to inline, and a search spends half of its time in them.
struct LaneVec {
  Lane x, y, z;
};

[[gnu::always_inline]] inline LaneVec operator-(const LaneVec& a, const LaneVec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

[[gnu::always_inline]] inline LaneVec cross(const LaneVec& a, const LaneVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

[[gnu::always_inline]] inline Lane dot(const LaneVec& a, const LaneVec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// Squared distances from the end of `arm` to the segments along `edge` that start where `arm` does.
[[gnu::always_inline]] inline Lane squared_distances_to_edges(const LaneVec& arm, const LaneVec& edge) {
  const Lane length = dot(edge, edge).max(std::numeric_limits<double>::min());
  const Lane along = (dot(edge, arm) / length).max(0.0).min(1.0);
  const LaneVec rest{arm.x - along * edge.x, arm.y - along * edge.y, arm.z - along * edge.z};
  return dot(rest, rest);
}

/// `closest_on_triangle` for the distance alone, four triangles at once.
template <typename Corners>
Lane squared_distances_to_triangles(const Corners& corner, const Vec3& point) {
  const auto load = [&](std::size_t i) { return LaneVec{lane(corner[i][0]), lane(corner[i][1]), lane(corner[i][2])}; };
  const LaneVec a = load(0);
  const LaneVec b = load(1);
  const LaneVec c = load(2);
  const LaneVec p{Lane::Constant(point.x()), Lane::Constant(point.y()), Lane::Constant(point.z())};
  const LaneVec ab = b - a;
  const LaneVec ac = c - a;
  const LaneVec ap = p - a;
  const Lane edges = squared_distances_to_edges(ap, ab)
                         .min(squared_distances_to_edges(p - b, c - b))
                         .min(squared_distances_to_edges(ap, ac));
  const LaneVec normal = cross(ab, ac);
  const Lane squared_normal = dot(normal, normal).max(std::numeric_limits<double>::min());
  const Lane v = dot(normal, cross(ap, ac)) / squared_normal;
  const Lane w = dot(normal, cross(ab, ap)) / squared_normal;
  const LaneVec rest{ap.x - v * ab.x - w * ac.x, ap.y - v * ab.y - w * ac.y, ap.z - v * ab.z - w * ac.z};
  return (v.min(w).min(1.0 - v - w) >= 0.0).select(dot(rest, rest).min(edges), edges);
}

}  // namespace

struct TriangleTree::Builder {
  const TriangleMesh& mesh;
  TriangleTree& tree;
  std::vector<Box> boxes;
  std::vector<Vec3> centres;
  std::vector<int> order;

  Builder(const TriangleMesh& mesh_, TriangleTree& tree_)
      : mesh(mesh_), tree(tree_), boxes(mesh_.triangles.size()), order(mesh_.triangles.size()) {
    centres.reserve(boxes.size());
    for (std::size_t t = 0; t < boxes.size(); ++t) {
      for (const int vertex : mesh.triangles[t]) {
        boxes[t].extend(mesh.vertices[static_cast<std::size_t>(vertex)]);
      }
      centres.push_back(0.5 * (boxes[t].lower + boxes[t].upper));
      order[t] = static_cast<int>(t);
    }
    tree.m_place.resize(boxes.size());
  }

  [[nodiscard]] const Vec3& centre(int place) const {
    return centres[static_cast<std::size_t>(order[static_cast<std::size_t>(place)])];
  }
  [[nodiscard]] const Box& box(int place) const {
    return boxes[static_cast<std::size_t>(order[static_cast<std::size_t>(place)])];
  }

  [[nodiscard]] std::pair<Range, Range> split(Range range, int depth) {
    Box spread;
    for (int i = range.begin; i < range.end; ++i) {
      spread.extend(centre(i));
    }
    int axis = 0;
    (spread.upper - spread.lower).maxCoeff(&axis);
    int middle = depth < deepest_by_area ? split_by_area(range, axis, spread) : range.begin;
    if (middle == range.begin || middle == range.end) {
      middle = range.begin + range.count() / 2;
      std::nth_element(order.begin() + range.begin, order.begin() + middle, order.begin() + range.end,
                       [&](int a, int b) {
                         const double x = centres[static_cast<std::size_t>(a)][axis];
                         const double y = centres[static_cast<std::size_t>(b)][axis];
                         return x < y || (x == y && a < b);
                       });
    }
    return {{range.begin, middle}, {middle, range.end}};
  }

  /// Surface-area heuristic over bins of the centres; returns the first place of the upper part.
  [[nodiscard]] int split_by_area(Range range, int axis, const Box& spread) {
    const double lower = spread.lower[axis];
    const double extent = spread.upper[axis] - lower;
    if (!(extent > 0)) {
      return range.begin;
    }
    const auto bin_of = [&](int triangle) {
      const double relative = (centres[static_cast<std::size_t>(triangle)][axis] - lower) / extent;
      return std::min(static_cast<int>(relative * bin_count), bin_count - 1);
    };
    std::array<Box, bin_count> bins;
    std::array<int, bin_count> counts{};
    for (int i = range.begin; i < range.end; ++i) {
      const auto bin = static_cast<std::size_t>(bin_of(order[static_cast<std::size_t>(i)]));
      bins[bin].extend(box(i));
      ++counts[bin];
    }
    std::array<double, bin_count> upper_cost{};
    Box right;
    int right_count = 0;
    for (std::size_t b = bin_count - 1; b > 0; --b) {
      right.extend(bins[b]);
      right_count += counts[b];
      upper_cost[b] = right.half_area() * right_count;
    }
    Box left;
    int left_count = 0;
    double best_cost = std::numeric_limits<double>::infinity();
    int best_bin = 0;
    for (std::size_t b = 1; b < bin_count; ++b) {
      left.extend(bins[b - 1]);
      left_count += counts[b - 1];
      const double cost = left.half_area() * left_count + upper_cost[b];
      if (left_count > 0 && left_count < range.count() && cost < best_cost) {
        best_cost = cost;
        best_bin = static_cast<int>(b);
      }
    }
    const auto middle = std::partition(order.begin() + range.begin, order.begin() + range.end,
                                       [&](int triangle) { return bin_of(triangle) < best_bin; });
    return static_cast<int>(middle - order.begin());
  }

  [[nodiscard]] Box box_of(Range range) const {
    Box all;
    for (int i = range.begin; i < range.end; ++i) {
      all.extend(box(i));
    }
    return all;
  }

  [[nodiscard]] Cluster cluster_of(Range range) const {
    const auto each_triangle = [&](auto&& visit) {
      for (int i = range.begin; i < range.end; ++i) {
        const Triangle& t = mesh.triangles[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])];
        visit(mesh.vertices[static_cast<std::size_t>(t[0])], mesh.vertices[static_cast<std::size_t>(t[1])],
              mesh.vertices[static_cast<std::size_t>(t[2])]);
      }
    };
    Cluster cluster;
    double area = 0;
    Vec3 weighted = Vec3::Zero();
    each_triangle([&](const Vec3& a, const Vec3& b, const Vec3& c) {
      const Vec3 area_normal = 0.5 * (b - a).cross(c - a);
      cluster.area_normal += area_normal;
      area += area_normal.norm();
      weighted += area_normal.norm() * (a + b + c) / 3;
    });
    const Box box = box_of(range);
    cluster.centre = area > 0 ? Vec3(weighted / area) : Vec3(0.5 * (box.lower + box.upper));
    each_triangle([&](const Vec3& a, const Vec3& b, const Vec3& c) {
      const double reach = std::sqrt(std::max({(a - cluster.centre).squaredNorm(), (b - cluster.centre).squaredNorm(),
                                               (c - cluster.centre).squaredNorm()}));
      cluster.radius = std::max(cluster.radius, reach);
    });
    return cluster;
  }

  /// Grown by the rounding of the products, so that a bound from it never exceeds a distance.
  void set_slab(Range range, Vec3 normal, std::size_t part, Node& node) const {
    const double length = normal.norm();
    normal = length > 0 ? Vec3(normal / length) : Vec3(Vec3::Zero());
    double lower = std::numeric_limits<double>::infinity();
    double upper = -lower;
    double reach = 0;
    for (int i = range.begin; i < range.end; ++i) {
      for (const int vertex : mesh.triangles[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])]) {
        const Vec3& point = mesh.vertices[static_cast<std::size_t>(vertex)];
        lower = std::min(lower, normal.dot(point));
        upper = std::max(upper, normal.dot(point));
        reach = std::max(reach, point.cwiseAbs().maxCoeff());
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.normal[axis][part] = normal[static_cast<Eigen::Index>(axis)];
    }
    node.slab_lower[part] = lower - rounding * reach;
    node.slab_upper[part] = upper + rounding * reach;
  }

  [[nodiscard]] int add_leaf(Range range) {
    Leaf leaf;
    leaf.count = range.count();
    const auto index = static_cast<int>(tree.m_leaves.size());
    for (int place = 0; place < width; ++place) {
      const int triangle = order[static_cast<std::size_t>(range.begin + (place < leaf.count ? place : 0))];
      const auto lane_index = static_cast<std::size_t>(place);
      leaf.triangle[lane_index] = triangle;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const int vertex = mesh.triangles[static_cast<std::size_t>(triangle)][corner];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          leaf.corner[corner][axis][lane_index] =
              mesh.vertices[static_cast<std::size_t>(vertex)][static_cast<Eigen::Index>(axis)];
        }
      }
      if (place < leaf.count) {
        tree.m_place[static_cast<std::size_t>(triangle)] = width * index + place;
      }
    }
    tree.m_leaves.push_back(leaf);
    return ~index;
  }

  /// Returns what a parent's `child` holds.
  [[nodiscard]] int add(Range range, int depth) {
    std::array<Range, width> parts{range};
    int count = 1;
    while (count < width) {
      const auto largest = std::max_element(parts.begin(), parts.begin() + count,
                                            [](const Range& a, const Range& b) { return a.count() < b.count(); });
      if (largest->count() <= width) {
        break;
      }
      const auto [lower, upper] = split(*largest, depth);
      *largest = lower;
      parts[static_cast<std::size_t>(count++)] = upper;
    }
    Node node{};
    std::array<Cluster, width> clusters;
    for (std::size_t part = 0; part < width; ++part) {
      const bool used = static_cast<int>(part) < count;
      const Box box = used ? box_of(parts[part]) : Box{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node.lower[axis][part] = box.lower[static_cast<Eigen::Index>(axis)];
        node.upper[axis][part] = box.upper[static_cast<Eigen::Index>(axis)];
      }
      if (used) {
        clusters[part] = cluster_of(parts[part]);
        set_slab(parts[part], clusters[part].area_normal, part, node);
      }
    }
    const auto index = tree.m_nodes.size();
    tree.m_nodes.push_back(node);
    tree.m_clusters.push_back(clusters);
    for (std::size_t part = 0; static_cast<int>(part) < count; ++part) {
      const Range range_of_part = parts[part];
      const int child = range_of_part.count() <= width ? add_leaf(range_of_part) : add(range_of_part, depth + 1);
      tree.m_nodes[index].child[part] = child;
    }
    return static_cast<int>(index);
  }
};

TriangleTree::TriangleTree(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) {
    return;
  }
  Builder builder(mesh, *this);
  (void)builder.add({0, static_cast<int>(mesh.triangles.size())}, 0);
  m_nodes.shrink_to_fit();
  m_clusters.shrink_to_fit();
  m_leaves.shrink_to_fit();
}

std::array<Vec3, 3> TriangleTree::corners(int triangle) const {
  const int place = m_place[static_cast<std::size_t>(triangle)];
  const Leaf& leaf = m_leaves[static_cast<std::size_t>(place / width)];
  const auto lane_index = static_cast<std::size_t>(place % width);
  std::array<Vec3, 3> result;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    result[corner] = {leaf.corner[corner][0][lane_index], leaf.corner[corner][1][lane_index],
                      leaf.corner[corner][2][lane_index]};
  }
  return result;
}

Vec3 TriangleTree::area_normal(int triangle) const {
  const auto [a, b, c] = corners(triangle);
  return (b - a).cross(c - a);
}

struct TriangleTree::Search {
  Vec3 point;
  ClosestOnTriangle best;
  int triangle = -1;
  /// Not worth its while where the search starts with a bound that is nearly the answer.
  bool nearest_first = true;

  void offer(const ClosestOnTriangle& candidate, int index) {
    if (candidate.squared_distance_m2 < best.squared_distance_m2 ||
        (candidate.squared_distance_m2 == best.squared_distance_m2 && (triangle < 0 || index < triangle))) {
      best = candidate;
      triangle = index;
    }
  }
};

void TriangleTree::search_leaf(const Leaf& leaf, Search& state) const {
  const Lane squared = squared_distances_to_triangles(leaf.corner, state.point);
  for (int place = 0; place < leaf.count; ++place) {
    // The slack lets the exact function, not the order of its operations here, decide between near equals.
    if (squared[place] <= state.best.squared_distance_m2 * (1 + 1e-12)) {
      const int triangle = leaf.triangle[static_cast<std::size_t>(place)];
      const auto [a, b, c] = corners(triangle);
      state.offer(closest_on_triangle(state.point, a, b, c), triangle);
    }
  }
}

void TriangleTree::search(Search& state) const {
  struct Entry {
    double squared_distance;
    int child;
  };
  std::array<Entry, stack_capacity> stack;
  int top = 0;
  stack[0] = {0, 0};
  while (top >= 0) {
    const Entry entry = stack[static_cast<std::size_t>(top--)];
    if (entry.squared_distance > state.best.squared_distance_m2) {
      continue;
    }
    if (entry.child < 0) {
      search_leaf(m_leaves[static_cast<std::size_t>(~entry.child)], state);
      continue;
    }
    const Node& node = m_nodes[static_cast<std::size_t>(entry.child)];
    Lane squared = Lane::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double p = state.point[static_cast<Eigen::Index>(axis)];
      squared += (lane(node.lower[axis]) - p).max(p - lane(node.upper[axis])).max(0.0).square();
    }
    Lane height = Lane::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      height += state.point[static_cast<Eigen::Index>(axis)] * lane(node.normal[axis]);
    }
    height = (lane(node.slab_lower) - height).max(height - lane(node.slab_upper)).max(0.0) * (1 - rounding);
    squared = squared.max(height.square());
    const int base = top;
    for (std::size_t part = 0; part < width; ++part) {
      const double distance = squared[static_cast<Eigen::Index>(part)];
      stack[static_cast<std::size_t>(top + 1)] = {distance, node.child[part]};
      top += static_cast<int>(distance <= state.best.squared_distance_m2);  // no branch: there is no foretelling it
    }
    for (int last = base + 2; state.nearest_first && last <= top; ++last) {
      for (int at = last; at > base + 1; --at) {
        Entry& upper = stack[static_cast<std::size_t>(at)];
        Entry& lower = stack[static_cast<std::size_t>(at - 1)];
        if (lower.squared_distance >= upper.squared_distance) {
          break;
        }
        std::swap(lower, upper);
      }
    }
  }
}

std::optional<ClosestPoint> TriangleTree::closest_point(const Vec3& point, double max_distance_m) const {
  if (m_nodes.empty() || !(max_distance_m >= 0)) {
    return std::nullopt;
  }
  Search state{.point = point, .best = {}};
  // Finite, so that the infinitely far unused children are never visited.
  state.best.squared_distance_m2 = std::min(max_distance_m * max_distance_m, std::numeric_limits<double>::max());
  search(state);
  if (state.triangle < 0) {
    return std::nullopt;
  }
  return ClosestPoint{state.best.point, std::sqrt(state.best.squared_distance_m2), state.triangle, state.best.feature};
}

ClosestPoint TriangleTree::closest_point_from(const Vec3& point, int triangle) const {
  const auto [a, b, c] = corners(triangle);
  Search state{
      .point = point, .best = closest_on_triangle(point, a, b, c), .triangle = triangle, .nearest_first = false};
  search(state);
  return {state.best.point, std::sqrt(state.best.squared_distance_m2), state.triangle, state.best.feature};
}

double TriangleTree::leaf_winding(const Leaf& leaf, const Vec3& point) const {
  double angle = 0;
  for (int place = 0; place < leaf.count; ++place) {
    const auto [a, b, c] = corners(leaf.triangle[static_cast<std::size_t>(place)]);
    angle += solid_angle(point, a, b, c);
  }
  return angle / (4 * std::numbers::pi);
}

double TriangleTree::winding_number(const Vec3& point, double opening) const {
  double winding = 0;
  std::array<int, stack_capacity> stack;
  int top = 0;
  stack[0] = 0;
  while (top >= 0) {
    const auto index = static_cast<std::size_t>(stack[static_cast<std::size_t>(top--)]);
    const Node& node = m_nodes[index];
    for (std::size_t part = 0; part < width && node.lower[0][part] <= node.upper[0][part]; ++part) {
      const Cluster& cluster = m_clusters[index][part];
      const Vec3 arm = cluster.centre - point;
      const double squared = arm.squaredNorm();
      if (squared > opening * opening * cluster.radius * cluster.radius) {
        winding += cluster.area_normal.dot(arm) / (4 * std::numbers::pi * squared * std::sqrt(squared));
      } else if (node.child[part] < 0) {
        winding += leaf_winding(m_leaves[static_cast<std::size_t>(~node.child[part])], point);
      } else {
        stack[static_cast<std::size_t>(++top)] = node.child[part];
      }
    }
  }
  return winding;
}

double TriangleTree::winding_number(const Vec3& point) const {
  if (m_nodes.empty()) {
    return 0;
  }
  for (const double opening : {2.0, 4.0, 8.0}) {
    const double winding = winding_number(point, opening);
    if (std::abs(winding - 0.5) > safe_margin) {
      return winding;
    }
  }
  return winding_number(point, std::numeric_limits<double>::infinity());
}

std::size_t TriangleTree::bytes() const {
  return m_nodes.capacity() * sizeof(Node) + m_clusters.capacity() * sizeof(m_clusters[0]) +
         m_leaves.capacity() * sizeof(Leaf) + m_place.capacity() * sizeof(int);
}

}  // namespace musclebench
