#include "core/geometry/triangle_tree_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace musclebench {

namespace {

constexpr int bin_count = 16;
/// Beyond this depth ranges are halved by count, which bounds the depth of the tree, and so of the stacks, for any
/// mesh.
constexpr int deepest_by_area = 24;
/// Squares of the sines between which `closest_on_triangle` rounds more than the slack of a search allows: its error is
/// a few units of rounding over the square, and below the smaller one it takes the triangle for a segment.
constexpr double needle_squared_sine = 1e-6;
constexpr double segment_squared_sine = 1e-27;

float round_down(double value) {
  const auto rounded = static_cast<float>(value);
  return rounded > value ? std::nextafter(rounded, -std::numeric_limits<float>::infinity()) : rounded;
}

float round_up(double value) { return -round_down(-value); }

int leaves_for(int triangles) {
  constexpr int width = static_cast<int>(tree_width);
  return (triangles + width - 1) / width;
}

/// A unit vector across the unit vector `along`.
Vec3 any_across(const Vec3& along) {
  int axis = 0;
  along.cwiseAbs().minCoeff(&axis);
  return along.cross(Vec3::Unit(axis)).normalized();
}

void put(const Vec3& vector, std::size_t place, std::array<TreeLanes, 3>& lanes) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lanes[axis][place] = static_cast<float>(vector[static_cast<Eigen::Index>(axis)]);
  }
}

}  // namespace

TriangleTreeBuilder::TriangleTreeBuilder(const TriangleMesh& mesh, TriangleTree& tree)
    : m_tree(tree), m_boxes(mesh.triangles.size()), m_order(mesh.triangles.size()) {
  m_tree.m_corners.reserve(m_boxes.size());
  m_centres.reserve(m_boxes.size());
  for (std::size_t t = 0; t < m_boxes.size(); ++t) {
    const auto corner = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][i])]; };
    m_tree.m_corners.push_back({corner(0), corner(1), corner(2)});
    for (const Vec3& position : m_tree.m_corners.back()) {
      m_boxes[t].extend(position);
    }
    m_centres.push_back(0.5 * (m_boxes[t].lower + m_boxes[t].upper));
    m_order[t] = static_cast<int>(t);
  }
  m_tree.m_leaf_of.resize(m_boxes.size());
}

void TriangleTreeBuilder::build() {
  choose_frame();
  (void)add({0, static_cast<int>(m_order.size())}, 0);
  m_tree.m_nodes.shrink_to_fit();
  m_tree.m_clusters.shrink_to_fit();
  m_tree.m_leaves.shrink_to_fit();
}

void TriangleTreeBuilder::choose_frame() {
  Box all;
  for (const Box& box : m_boxes) {
    all.extend(box);
  }
  m_tree.m_centre_m = 0.5 * (all.lower + all.upper);
  int exponent = 0;
  (void)std::frexp((0.5 * (all.upper - all.lower)).maxCoeff(), &exponent);
  m_tree.m_scale = std::ldexp(1.0, -exponent);
  m_tree.m_reach = m_tree.m_scale * all.lower.cwiseAbs().cwiseMax(all.upper.cwiseAbs()).maxCoeff();
}

std::pair<TriangleTreeBuilder::Range, TriangleTreeBuilder::Range> TriangleTreeBuilder::split(Range range, int depth) {
  const auto centre = [&](int triangle) -> const Vec3& { return m_centres[static_cast<std::size_t>(triangle)]; };
  Box spread;
  for (int i = range.begin; i < range.end; ++i) {
    spread.extend(centre(m_order[static_cast<std::size_t>(i)]));
  }
  int axis = 0;
  (spread.upper - spread.lower).maxCoeff(&axis);
  int middle = depth < deepest_by_area ? split_by_area(range, axis, spread) : range.begin;
  if (middle == range.begin || middle == range.end) {
    middle = range.begin + range.count() / 2;
    std::nth_element(m_order.begin() + range.begin, m_order.begin() + middle, m_order.begin() + range.end,
                     [&](int a, int b) {
                       const double x = centre(a)[axis];
                       const double y = centre(b)[axis];
                       return x < y || (x == y && a < b);
                     });
  }
  return {{range.begin, middle}, {middle, range.end}};
}

int TriangleTreeBuilder::split_by_area(Range range, int axis, const Box& spread) {
  const double lower = spread.lower[axis];
  const double extent = spread.upper[axis] - lower;
  if (!(extent > 0)) {
    return range.begin;
  }
  const auto bin_of = [&](int triangle) {
    const double relative = (m_centres[static_cast<std::size_t>(triangle)][axis] - lower) / extent;
    return std::min(static_cast<int>(relative * bin_count), bin_count - 1);
  };
  std::array<Box, bin_count> bins;
  std::array<int, bin_count> counts{};
  for (int i = range.begin; i < range.end; ++i) {
    const int triangle = m_order[static_cast<std::size_t>(i)];
    const auto bin = static_cast<std::size_t>(bin_of(triangle));
    bins[bin].extend(m_boxes[static_cast<std::size_t>(triangle)]);
    ++counts[bin];
  }
  std::array<double, bin_count> upper_cost{};
  Box right;
  int right_count = 0;
  for (std::size_t b = bin_count - 1; b > 0; --b) {
    right.extend(bins[b]);
    right_count += counts[b];
    upper_cost[b] = right.half_area() * leaves_for(right_count);
  }
  Box left;
  int left_count = 0;
  double best_cost = std::numeric_limits<double>::infinity();
  int best_bin = 0;
  for (std::size_t b = 1; b < bin_count; ++b) {
    left.extend(bins[b - 1]);
    left_count += counts[b - 1];
    const double cost = left.half_area() * leaves_for(left_count) + upper_cost[b];
    if (left_count > 0 && left_count < range.count() && cost < best_cost) {
      best_cost = cost;
      best_bin = static_cast<int>(b);
    }
  }
  const auto middle = std::partition(m_order.begin() + range.begin, m_order.begin() + range.end,
                                     [&](int triangle) { return bin_of(triangle) < best_bin; });
  return static_cast<int>(middle - m_order.begin());
}

TreeCluster TriangleTreeBuilder::cluster_of(Range range) const {
  TreeCluster cluster;
  Box box;
  double area = 0;
  Vec3 weighted = Vec3::Zero();
  for (int i = range.begin; i < range.end; ++i) {
    const auto& [a, b, c] = corners(i);
    const Vec3 area_normal = 0.5 * (b - a).cross(c - a);
    const double own_area = area_normal.norm();
    cluster.area_normal += area_normal;
    area += own_area;
    weighted += own_area * (a + b + c) / 3;
    box.extend(m_boxes[static_cast<std::size_t>(m_order[static_cast<std::size_t>(i)])]);
  }
  cluster.centre = area > 0 ? Vec3(weighted / area) : Vec3(0.5 * (box.lower + box.upper));
  double squared_radius = 0;
  for (int i = range.begin; i < range.end; ++i) {
    for (const Vec3& position : corners(i)) {
      squared_radius = std::max(squared_radius, (position - cluster.centre).squaredNorm());
    }
  }
  cluster.radius = std::sqrt(squared_radius);
  return cluster;
}

void TriangleTreeBuilder::set_bounds(Range range, const Vec3& area_normal, std::size_t place, TreeNode& node) const {
  const double length = area_normal.norm();
  // A little too short, so that its rounding makes it no longer than 1.
  const Vec3 wanted = length > 0 ? Vec3(area_normal * ((1 - 1e-6) / length)) : Vec3(Vec3::Zero());
  put(wanted, place, node.normal);
  const Vec3 normal(node.normal[0][place], node.normal[1][place], node.normal[2][place]);
  Box box;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (int i = range.begin; i < range.end; ++i) {
    for (const Vec3& position : corners(i)) {
      const Vec3 own = to_own(position);
      const double height = normal.dot(own);
      box.extend(own);
      lowest = std::min(lowest, height);
      highest = std::max(highest, height);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    node.lower[axis][place] = round_down(box.lower[static_cast<Eigen::Index>(axis)]);
    node.upper[axis][place] = round_up(box.upper[static_cast<Eigen::Index>(axis)]);
  }
  node.slab_lower[place] = round_down(lowest);
  node.slab_upper[place] = round_up(highest);
}

bool TriangleTreeBuilder::set_triangle(int triangle, std::size_t place, TreeLeaf& leaf) {
  const auto& exact = m_tree.m_corners[static_cast<std::size_t>(triangle)];
  const std::array<Vec3, 3> own = {to_own(exact[0]), to_own(exact[1]), to_own(exact[2])};
  std::size_t first = 0;
  double squared_length = -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const double squared = (own[(i + 1) % 3] - own[i]).squaredNorm();
    if (squared > squared_length) {
      squared_length = squared;
      first = i;
    }
  }
  const Vec3& from = own[first];
  const Vec3& to = own[(first + 1) % 3];
  const Vec3& tip = own[(first + 2) % 3];
  const double length = std::sqrt(squared_length);
  const Vec3 along = length > 0 ? Vec3((to - from) / length) : Vec3(Vec3::UnitX());
  const double before = std::clamp(along.dot(tip - from), 0.0, length);
  const Vec3 foot = from + before * along;
  // Made orthogonal twice: the first remainder of a needle is mostly rounding.
  Vec3 up = tip - foot;
  up -= along.dot(up) * along;
  const double height = up.norm();
  up = height > 0 ? Vec3(up / height) : any_across(along);
  up -= along.dot(up) * along;
  up = up.norm() > 0.5 ? Vec3(up.normalized()) : any_across(along);
  put(foot, place, leaf.origin);
  put(along, place, leaf.along);
  put(up, place, leaf.up);
  leaf.before[place] = static_cast<float>(before);
  leaf.after[place] = static_cast<float>(length - before);
  leaf.height[place] = static_cast<float>(height);
  leaf.triangle[place] = triangle;
  m_tree.m_longest_side = std::max(m_tree.m_longest_side, length);

  const Vec3 ab = exact[1] - exact[0];
  const Vec3 ac = exact[2] - exact[0];
  const double squared_normal = ab.cross(ac).squaredNorm();
  const double squared_sides = ab.squaredNorm() * ac.squaredNorm();
  return squared_normal < needle_squared_sine * squared_sides && squared_normal > segment_squared_sine * squared_sides;
}

int TriangleTreeBuilder::add_leaf(Range range) {
  TreeLeaf leaf{};
  leaf.count = range.count();
  const auto index = static_cast<int>(m_tree.m_leaves.size());
  for (std::size_t place = 0; place < tree_width; ++place) {
    if (static_cast<int>(place) < leaf.count) {
      const int triangle = m_order[static_cast<std::size_t>(range.begin) + place];
      leaf.needles |= static_cast<std::uint32_t>(set_triangle(triangle, place, leaf)) << place;
      m_tree.m_leaf_of[static_cast<std::size_t>(triangle)] = index;
    } else {
      put(Vec3::Constant(tree_nowhere), place, leaf.origin);
      put(Vec3::UnitX(), place, leaf.along);
      put(Vec3::UnitY(), place, leaf.up);
      leaf.triangle[place] = -1;
    }
  }
  m_tree.m_leaves.push_back(leaf);
  return ~index;
}

int TriangleTreeBuilder::add(Range range, int depth) {
  std::array<Range, tree_width> parts{range};
  std::size_t count = 1;
  while (count < tree_width) {
    const auto largest = std::max_element(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(count),
                                          [](const Range& a, const Range& b) { return a.count() < b.count(); });
    if (largest->fits_leaf()) {
      break;
    }
    const auto [lower, upper] = split(*largest, depth);
    *largest = lower;
    parts[count++] = upper;
  }
  TreeNode node{};
  std::array<TreeCluster, tree_width> clusters;
  for (std::size_t part = 0; part < tree_width; ++part) {
    if (part < count) {
      clusters[part] = cluster_of(parts[part]);
      set_bounds(parts[part], clusters[part].area_normal, part, node);
    } else {
      put(Vec3::Constant(tree_nowhere), part, node.lower);
      put(Vec3::Constant(-tree_nowhere), part, node.upper);
    }
  }
  const auto index = m_tree.m_nodes.size();
  m_tree.m_nodes.push_back(node);
  m_tree.m_clusters.push_back(clusters);
  for (std::size_t part = 0; part < count; ++part) {
    const int child = parts[part].fits_leaf() ? add_leaf(parts[part]) : add(parts[part], depth + 1);
    m_tree.m_nodes[index].child[part] = child;
  }
  return static_cast<int>(index);
}

}  // namespace musclebench
