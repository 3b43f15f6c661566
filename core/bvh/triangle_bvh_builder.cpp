#include "core/bvh/triangle_bvh_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace musclebench {

namespace {

constexpr int bin_count = 16;
/// Deeper ranges are halved by count, which bounds the depth of the tree, and so the stacks of its searches, for any
/// mesh.
constexpr int deepest_by_area = 24;
/// Range of the squared sine of a corner in which a triangle is a sliver: the error of `closest_on_triangle`, some
/// units of rounding over the squared sine, exceeds the slack of a search. Smaller ones are answered as segments,
/// exactly.
constexpr double sliver_squared_sine = 1e-6;
constexpr double segment_squared_sine = 1e-27;

/// Length of the axes of an OBB: short enough that neither rounding nor their not being quite orthogonal makes a
/// projection longer than the true distance.
constexpr double axis_length = 1 - 1e-6;

int leaves_for(int triangles) {
  constexpr int width = static_cast<int>(bvh_width);
  return (triangles + width - 1) / width;
}

/// A unit vector perpendicular to the unit vector `along`.
Vec3 any_perpendicular(const Vec3& along) {
  int axis = 0;
  along.cwiseAbs().minCoeff(&axis);
  return along.cross(Vec3::Unit(axis)).normalized();
}

void put(const Vec3& vector, std::size_t lane, std::array<BvhLanes, 3>& lanes) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lanes[axis][lane] = static_cast<float>(vector[static_cast<Eigen::Index>(axis)]);
  }
}

}  // namespace

TriangleBvhBuilder::TriangleBvhBuilder(const TriangleMesh& mesh, TriangleBvh& tree)
    : m_tree(tree), m_boxes(mesh.triangles.size()), m_order(mesh.triangles.size()) {
  m_tree.m_corners.reserve(m_boxes.size());
  for (const Triangle& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(triangle[i])]; };
    m_tree.m_corners.push_back({corner(0), corner(1), corner(2)});
  }
  m_tree.m_leaf_of.resize(m_boxes.size());
}

void TriangleBvhBuilder::build() {
  choose_frame();
  for (std::size_t t = 0; t < m_boxes.size(); ++t) {
    const auto& [a, b, c] = m_tree.m_corners[t];
    m_boxes[t].lower.head<3>() = to_tree_frame(a.cwiseMin(b).cwiseMin(c)).cast<float>().array();
    m_boxes[t].negated_upper.head<3>() = -to_tree_frame(a.cwiseMax(b).cwiseMax(c)).cast<float>().array();
    m_order[t] = static_cast<int>(t);
  }
  // About as many as there will be, so that growing copies little: memory that is not written costs nothing.
  m_tree.m_nodes.reserve(m_order.size() / 16);
  m_tree.m_clusters.reserve(m_order.size() / 16);
  m_noted.reserve(m_order.size() / 4);
  (void)add({0, static_cast<int>(m_order.size())}, 0);
  m_tree.m_nodes.shrink_to_fit();
  m_tree.m_clusters.shrink_to_fit();
  fill_leaves();
}

void TriangleBvhBuilder::choose_frame() {
  Vec3 lower = m_tree.m_corners.front().front();
  Vec3 upper = lower;
  for (const auto& corners_of_one : m_tree.m_corners) {
    for (const Vec3& position : corners_of_one) {
      lower = lower.cwiseMin(position);
      upper = upper.cwiseMax(position);
    }
  }
  m_tree.m_centre_m = 0.5 * (lower + upper);
  int exponent = 0;
  (void)std::frexp((0.5 * (upper - lower)).maxCoeff(), &exponent);
  m_tree.m_scale = std::ldexp(1.0, -exponent);
  m_tree.m_reach = m_tree.m_scale * lower.cwiseAbs().cwiseMax(upper.cwiseAbs()).maxCoeff();
}

std::pair<TriangleBvhBuilder::Range, TriangleBvhBuilder::Range> TriangleBvhBuilder::split(Range range, int depth) {
  Box spread;  // of the doubled centres
  for (int i = range.begin; i < range.end; ++i) {
    const Eigen::Array4f centre = box(i).doubled_centre();
    spread.extend({centre, -centre});
  }
  int middle = depth < deepest_by_area ? split_by_area(range, spread) : range.begin;
  if (middle == range.begin || middle == range.end) {
    middle = halve(range, spread);
  }
  return {{range.begin, middle}, {middle, range.end}};
}

int TriangleBvhBuilder::halve(Range range, const Box& spread) {
  int axis = 0;
  (-spread.negated_upper - spread.lower).head<3>().maxCoeff(&axis);
  const auto centre = [&](int triangle) { return m_boxes[static_cast<std::size_t>(triangle)].doubled_centre()[axis]; };
  const int middle = range.begin + range.count() / 2;
  std::nth_element(m_order.begin() + range.begin, m_order.begin() + middle, m_order.begin() + range.end,
                   [&](int a, int b) {
                     const float x = centre(a);
                     const float y = centre(b);
                     return x < y || (x == y && a < b);
                   });
  return middle;
}

int TriangleBvhBuilder::split_by_area(Range range, const Box& spread) {
  const Eigen::Array4f extent = -spread.negated_upper - spread.lower;
  // Just below the number of bins, so that the last centre falls into the last bin; 0 where all coincide.
  const Eigen::Array4f bins_per_unit = (extent > 0).select((bin_count * 0.9999F) / extent, 0.0F);
  const auto bins_of = [&](int triangle) -> Eigen::Array4i {
    const Eigen::Array4f centre = m_boxes[static_cast<std::size_t>(triangle)].doubled_centre();
    return ((centre - spread.lower) * bins_per_unit).min(bin_count - 1.0F).max(0.0F).cast<int>();
  };
  struct Bin {
    Box box;
    int count = 0;
  };
  std::array<std::array<Bin, bin_count>, 3> bins;
  for (int i = range.begin; i < range.end; ++i) {
    const int triangle = m_order[static_cast<std::size_t>(i)];
    const Eigen::Array4i bin_indices = bins_of(triangle);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Bin& bin = bins[axis][static_cast<std::size_t>(bin_indices[static_cast<Eigen::Index>(axis)])];
      bin.box.extend(m_boxes[static_cast<std::size_t>(triangle)]);
      ++bin.count;
    }
  }
  float best_cost = std::numeric_limits<float>::infinity();
  Eigen::Index best_axis = 0;
  int best_bin = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<float, bin_count> upper_cost{};
    Bin right;
    for (std::size_t b = bin_count - 1; b > 0; --b) {
      right.box.extend(bins[axis][b].box);
      right.count += bins[axis][b].count;
      upper_cost[b] = right.box.half_area() * leaves_for(right.count);
    }
    Bin left;
    for (std::size_t b = 1; b < bin_count; ++b) {
      left.box.extend(bins[axis][b - 1].box);
      left.count += bins[axis][b - 1].count;
      const float cost = left.box.half_area() * leaves_for(left.count) + upper_cost[b];
      if (left.count > 0 && left.count < range.count() && cost < best_cost) {
        best_cost = cost;
        best_axis = static_cast<Eigen::Index>(axis);
        best_bin = static_cast<int>(b);
      }
    }
  }
  const auto middle = std::partition(m_order.begin() + range.begin, m_order.begin() + range.end,
                                     [&](int triangle) { return bins_of(triangle)[best_axis] < best_bin; });
  return static_cast<int>(middle - m_order.begin());
}

BvhCluster TriangleBvhBuilder::cluster_of(Range range) const {
  BvhCluster cluster;
  Vec3 lower = corners(range.begin)[0];
  Vec3 upper = lower;
  double area = 0;
  Vec3 weighted = Vec3::Zero();
  for (int i = range.begin; i < range.end; ++i) {
    const auto& [a, b, c] = corners(i);
    const Vec3 area_normal = 0.5 * (b - a).cross(c - a);
    const double triangle_area = area_normal.norm();
    cluster.area_normal += area_normal;
    area += triangle_area;
    weighted += triangle_area * (a + b + c) / 3;
    lower = lower.cwiseMin(a).cwiseMin(b).cwiseMin(c);
    upper = upper.cwiseMax(a).cwiseMax(b).cwiseMax(c);
  }
  cluster.centre = area > 0 ? Vec3(weighted / area) : Vec3(0.5 * (lower + upper));
  double squared_radius = 0;
  for (int i = range.begin; i < range.end; ++i) {
    for (const Vec3& position : corners(i)) {
      squared_radius = std::max(squared_radius, (position - cluster.centre).squaredNorm());
    }
  }
  cluster.radius = std::sqrt(squared_radius);
  return cluster;
}

Vec3 TriangleBvhBuilder::longest_tangent(Range range, const Vec3& normal) const {
  const Vec3 first = any_perpendicular(normal);
  const Vec3 second = normal.cross(first);
  // Principal axis of the triangles' centres in the tangent plane, relative to the first corner. Scaled by 3, which
  // cancels.
  const Vec3 origin = corners(range.begin)[0];
  double x = 0;
  double y = 0;
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (int i = range.begin; i < range.end; ++i) {
    const auto& [a, b, c] = corners(i);
    const Vec3 arm = m_tree.m_scale * ((a - origin) + (b - origin) + (c - origin));
    const double u = first.dot(arm);
    const double v = second.dot(arm);
    x += u;
    y += v;
    xx += u * u;
    xy += u * v;
    yy += v * v;
  }
  const double count = range.count();
  // Half of the angle of (difference, twice the covariance), by its sine and cosine.
  const double difference = (xx - x * x / count) - (yy - y * y / count);
  const double twice_covariance = 2 * (xy - x * y / count);
  const double length = std::sqrt(difference * difference + twice_covariance * twice_covariance);
  const double cosine = length > 0 ? difference / length : 1;
  const double half_cosine = std::sqrt(std::max(0.0, 0.5 * (1 + cosine)));
  const double half_sine = std::copysign(std::sqrt(std::max(0.0, 0.5 * (1 - cosine))), twice_covariance);
  return half_cosine * first + half_sine * second;
}

void TriangleBvhBuilder::set_bounds(Range range, const Vec3& area_normal, std::size_t lane, BvhNode& node) const {
  const double length = area_normal.norm();
  const Vec3 unit = length > 0 ? Vec3(area_normal / length) : Vec3(Vec3::UnitZ());
  put(axis_length * unit, lane, node.normal);
  put(axis_length * longest_tangent(range, unit), lane, node.tangent);
  // Rounded to single precision, as the search uses them.
  const Vec3 normal(node.normal[0][lane], node.normal[1][lane], node.normal[2][lane]);
  const Vec3 tangent(node.tangent[0][lane], node.tangent[1][lane], node.tangent[2][lane]);
  const Vec3 third = normal.cross(tangent);
  Vec3 lower = to_tree_frame(corners(range.begin)[0]);
  Vec3 upper = lower;
  Vec3 obb_lower(normal.dot(lower), tangent.dot(lower), third.dot(lower));
  Vec3 obb_upper = obb_lower;
  for (int i = range.begin; i < range.end; ++i) {
    for (const Vec3& position : corners(i)) {
      const Vec3 local = to_tree_frame(position);
      const Vec3 projected(normal.dot(local), tangent.dot(local), third.dot(local));
      lower = lower.cwiseMin(local);
      upper = upper.cwiseMax(local);
      obb_lower = obb_lower.cwiseMin(projected);
      obb_upper = obb_upper.cwiseMax(projected);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    node.lower[axis][lane] = bvh_round_down(lower[static_cast<Eigen::Index>(axis)]);
    node.upper[axis][lane] = bvh_round_up(upper[static_cast<Eigen::Index>(axis)]);
    node.obb_lower[axis][lane] = bvh_round_down(obb_lower[static_cast<Eigen::Index>(axis)]);
    node.obb_upper[axis][lane] = bvh_round_up(obb_upper[static_cast<Eigen::Index>(axis)]);
  }
}

bool TriangleBvhBuilder::set_triangle(int triangle, std::size_t lane, BvhLeaf& leaf) {
  const auto& exact = m_tree.m_corners[static_cast<std::size_t>(triangle)];
  const std::array<Vec3, 3> local = {to_tree_frame(exact[0]), to_tree_frame(exact[1]), to_tree_frame(exact[2])};
  std::size_t first = 0;
  double squared_length = -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const double squared = (local[(i + 1) % 3] - local[i]).squaredNorm();
    if (squared > squared_length) {
      squared_length = squared;
      first = i;
    }
  }
  const Vec3& from = local[first];
  const Vec3& to = local[(first + 1) % 3];
  const Vec3& tip = local[(first + 2) % 3];
  const double length = std::sqrt(squared_length);
  const Vec3 along = length > 0 ? Vec3((to - from) / length) : Vec3(Vec3::UnitX());
  const double before = std::clamp(along.dot(tip - from), 0.0, length);
  const Vec3 foot = from + before * along;
  // Orthogonalised twice: what the first pass leaves of a sliver's height is mostly rounding.
  Vec3 up = tip - foot;
  up -= along.dot(up) * along;
  const double height = up.norm();
  up = height > 0 ? Vec3(up / height) : any_perpendicular(along);
  up -= along.dot(up) * along;
  up = up.norm() > 0.5 ? Vec3(up.normalized()) : any_perpendicular(along);
  put(foot, lane, leaf.origin);
  put(along, lane, leaf.along);
  put(up, lane, leaf.up);
  leaf.before[lane] = static_cast<float>(before);
  leaf.after[lane] = static_cast<float>(length - before);
  leaf.height[lane] = static_cast<float>(height);
  leaf.triangle[lane] = triangle;
  m_tree.m_longest_side = std::max(m_tree.m_longest_side, length);

  const Vec3 ab = exact[1] - exact[0];
  const Vec3 ac = exact[2] - exact[0];
  const double squared_normal = ab.cross(ac).squaredNorm();
  const double squared_sides = ab.squaredNorm() * ac.squaredNorm();
  return squared_normal < sliver_squared_sine * squared_sides && squared_normal > segment_squared_sine * squared_sides;
}

int TriangleBvhBuilder::add_leaf(Range range) {
  NotedLeaf& noted = m_noted.emplace_back();
  noted.range = range;
  noted.ancestors.fill(-1);
  std::copy_n(m_path.rbegin(), std::min(m_path.size(), noted.ancestors.size()), noted.ancestors.begin());
  return ~static_cast<int>(m_noted.size() - 1);
}

void TriangleBvhBuilder::fill_leaves() {
  m_tree.m_leaves.resize(m_noted.size());
  for (std::size_t index = 0; index < m_noted.size(); ++index) {
    BvhLeaf& leaf = m_tree.m_leaves[index];
    const Range range = m_noted[index].range;
    leaf.count = range.count();
    leaf.ancestors = m_noted[index].ancestors;
    for (std::size_t lane = 0; lane < bvh_width; ++lane) {
      if (static_cast<int>(lane) < leaf.count) {
        const int triangle = m_order[static_cast<std::size_t>(range.begin) + lane];
        leaf.slivers |= static_cast<std::uint32_t>(set_triangle(triangle, lane, leaf)) << lane;
        m_tree.m_leaf_of[static_cast<std::size_t>(triangle)] = static_cast<int>(index);
      } else {
        put(Vec3::Constant(bvh_far_away), lane, leaf.origin);
        put(Vec3::UnitX(), lane, leaf.along);
        put(Vec3::UnitY(), lane, leaf.up);
        leaf.triangle[lane] = -1;
      }
    }
  }
}

int TriangleBvhBuilder::add(Range range, int depth) {
  std::array<Range, bvh_width> parts{range};
  std::size_t count = 1;
  while (count < bvh_width) {
    const auto largest = std::max_element(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(count),
                                          [](const Range& a, const Range& b) { return a.count() < b.count(); });
    if (largest->fits_leaf()) {
      break;
    }
    const auto [lower, upper] = split(*largest, depth);
    *largest = lower;
    parts[count++] = upper;
  }
  BvhNode node{};
  BvhClusters clusters;
  for (std::size_t part = 0; part < bvh_width; ++part) {
    if (part < count) {
      clusters[part] = cluster_of(parts[part]);
      set_bounds(parts[part], clusters[part].area_normal, part, node);
    } else {
      put(Vec3::Constant(bvh_far_away), part, node.lower);
      put(Vec3::Constant(-bvh_far_away), part, node.upper);
    }
  }
  const auto index = m_tree.m_nodes.size();
  m_tree.m_nodes.push_back(node);
  m_tree.m_clusters.push_back(clusters);
  m_path.push_back(static_cast<std::int32_t>(index));
  for (std::size_t part = 0; part < count; ++part) {
    const int child = parts[part].fits_leaf() ? add_leaf(parts[part]) : add(parts[part], depth + 1);
    m_tree.m_nodes[index].child[part] = child;
  }
  m_path.pop_back();
  return static_cast<int>(index);
}

}  // namespace musclebench
