#include "core/bvh/moving_surface_tree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/bvh/bvh_lanes.hpp"
#include "core/distance/line_crossing.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// More than the relative rounding errors of distances that are compared.
constexpr double rounding = 1e-9;
/// Largest displacement without a refit, over the mean size of a triangle. A refit costs about as much as the queries
/// of a hundred steps in which most nodes are known to be free; a larger displacement makes each of them visit more
/// boxes.
constexpr double farthest_travel = 0.25;

/// Bounds the rounding error of a box, a point or a distance in single precision, relative to the lengths involved.
constexpr double float_slack = 0x1p-21;

void make_unused(MovingBoxes& boxes) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    boxes.lower[axis].fill(std::numeric_limits<float>::infinity());
    boxes.upper[axis].fill(-std::numeric_limits<float>::infinity());
  }
}

}  // namespace

/// The closest triangle so far, and the squared distance beyond which boxes are culled.
struct MovingSurfaceTree::Best {
  ClosestOnTriangle found;
  int triangle = -1;
  double margin_m;
  float squared_limit_m2;

  Best(double max_distance_m, double margin) : margin_m(margin) {
    found.squared_distance_m2 = std::min(max_distance_m * max_distance_m, std::numeric_limits<double>::max());
    set_limit();
  }
  void set_limit() {
    const double limit_m = (std::sqrt(found.squared_distance_m2) + margin_m) * (1 + float_slack);
    squared_limit_m2 = static_cast<float>(std::min<double>(limit_m * limit_m, std::numeric_limits<float>::max()));
  }
};

MovingSurfaceTree::MovingSurfaceTree(const TriangleMesh& mesh, const Body& body)
    : m_triangles(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(body.first_triangle),
                  mesh.triangles.begin() + static_cast<std::ptrdiff_t>(body.last_triangle)),
      m_first_triangle(body.first_triangle),
      m_first_node(static_cast<std::size_t>(body.first_node)),
      m_fitted(mesh.vertices.begin() + body.first_node, mesh.vertices.begin() + body.last_node) {
  TriangleMesh own{m_fitted, m_triangles};
  for (Triangle& triangle : own.triangles) {
    for (int& corner : triangle) corner -= body.first_node;
  }
  m_farthest_m = farthest_travel * mean_triangle_size_m(own);
  // Topology of a TriangleBvh at rest; only the bounds are refitted.
  const TriangleBvh rest(own);
  m_nodes.resize(rest.m_nodes.size());
  for (std::size_t i = 0; i < m_nodes.size(); ++i) {
    m_nodes[i].child = rest.m_nodes[i].child;  // no child is the root: 0 is an unused lane
    make_unused(m_nodes[i].boxes);
  }
  m_leaves.resize(rest.m_leaves.size());
  for (std::size_t i = 0; i < m_leaves.size(); ++i) {
    m_leaves[i].count = rest.m_leaves[i].count;
    make_unused(m_leaves[i].boxes);
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(m_leaves[i].count); ++lane) {
      m_leaves[i].triangle[lane] = rest.m_leaves[i].triangle[lane] + static_cast<int>(m_first_triangle);
    }
  }
  m_vertices = mesh.vertices;
  refit(1);
}

void MovingSurfaceTree::update(std::span<const Vec3> vertices, int threads) {
  m_vertices = vertices;
  double squared_m2 = 0;
  bool all_finite = true;
  for (std::size_t i = 0; i < m_fitted.size(); ++i) {
    const double moved_m2 = (vertices[m_first_node + i] - m_fitted[i]).squaredNorm();
    all_finite = all_finite && std::isfinite(moved_m2);
    squared_m2 = std::max(squared_m2, moved_m2);
  }
  m_travel_m = std::sqrt(squared_m2) * (1 + rounding);
  // Without finite vertices there is no box; the run ends as diverged after this frame.
  if (all_finite && m_travel_m > m_farthest_m) {
    refit(threads);
  }
}

void MovingSurfaceTree::refit([[maybe_unused]] int threads) {
  ++m_refits;
  m_travel_m = 0;
  std::copy_n(m_vertices.begin() + static_cast<std::ptrdiff_t>(m_first_node), m_fitted.size(), m_fitted.begin());
  m_box = bounding_box(m_fitted);
  m_origin = m_box.center();
  m_fitted_local.resize(m_fitted.size());
  for (std::size_t i = 0; i < m_fitted.size(); ++i) m_fitted_local[i] = to_boxes(m_fitted[i]);
  if (threads > 1) {  // OpenMP allocates even a team of one
#pragma omp parallel for schedule(static) num_threads(threads)
    for (std::size_t i = 0; i < m_leaves.size(); ++i) fit_leaf(i);
  } else {
    for (std::size_t i = 0; i < m_leaves.size(); ++i) fit_leaf(i);
  }
  // From the last node to the root: children come after their parent.
  for (std::size_t n = m_nodes.size(); n-- > 0;) {
    Node& node = m_nodes[n];
    for (std::size_t lane = 0; lane < width; ++lane) {
      const std::int32_t child = node.child[lane];
      if (child == 0) {
        continue;
      }
      const MovingBoxes& below =
          child < 0 ? m_leaves[static_cast<std::size_t>(~child)].boxes : m_nodes[static_cast<std::size_t>(child)].boxes;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        float lower = below.lower[axis][0];
        float upper = below.upper[axis][0];
        for (std::size_t i = 1; i < width; ++i) {
          lower = std::min(lower, below.lower[axis][i]);
          upper = std::max(upper, below.upper[axis][i]);
        }
        node.boxes.lower[axis][lane] = lower;
        node.boxes.upper[axis][lane] = upper;
      }
    }
  }
}

void MovingSurfaceTree::fit_leaf(std::size_t index) {
  Leaf& leaf = m_leaves[index];
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(leaf.count); ++lane) {
    const auto& [a, b, c] = m_triangles[static_cast<std::size_t>(leaf.triangle[lane]) - m_first_triangle];
    const std::array<float, 3>& p = m_fitted_local[static_cast<std::size_t>(a) - m_first_node];
    const std::array<float, 3>& q = m_fitted_local[static_cast<std::size_t>(b) - m_first_node];
    const std::array<float, 3>& r = m_fitted_local[static_cast<std::size_t>(c) - m_first_node];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      leaf.boxes.lower[axis][lane] = std::min(std::min(p[axis], q[axis]), r[axis]);
      leaf.boxes.upper[axis][lane] = std::max(std::max(p[axis], q[axis]), r[axis]);
    }
  }
}

std::array<float, 3> MovingSurfaceTree::to_boxes(const Vec3& point) const {
  const Vec3 local = point - m_origin;
  return {static_cast<float>(local.x()), static_cast<float>(local.y()), static_cast<float>(local.z())};
}

double MovingSurfaceTree::margin_m(const Vec3& point) const {
  return m_travel_m + float_slack * (m_box.diagonal().norm() + (point - m_origin).norm());
}

void MovingSurfaceTree::consider(const Vec3& point, int triangle, Best& best) const {
  const auto& [a, b, c] = m_triangles[static_cast<std::size_t>(triangle) - m_first_triangle];
  const ClosestOnTriangle found =
      closest_on_triangle(point, m_vertices[static_cast<std::size_t>(a)], m_vertices[static_cast<std::size_t>(b)],
                          m_vertices[static_cast<std::size_t>(c)]);
  if (found.squared_distance_m2 < best.found.squared_distance_m2 ||
      (found.squared_distance_m2 == best.found.squared_distance_m2 && triangle < best.triangle)) {
    best.found = found;
    best.triangle = triangle;
    best.set_limit();
  }
}

ClosestPoint MovingSurfaceTree::closest_point(const Vec3& point, int guess, double max_distance_m,
                                              std::span<const int> left_out) const {
  Best best(max_distance_m, margin_m(point));
  if (guess >= 0) {
    consider(point, guess, best);
  }
  const std::array<float, 3> local = to_boxes(point);
  struct Waiting {
    std::int32_t child;
    float squared_m2;
  };
  std::array<Waiting, bvh_stack_capacity> stack;
  std::size_t waiting = 0;
  stack[waiting++] = {0, 0};
  BvhLanes squared_m2;
  while (waiting > 0) {
    const auto [child, nearest_m2] = stack[--waiting];
    if (!(nearest_m2 <= best.squared_limit_m2)) {
      continue;
    }
    if (child < 0) {
      const Leaf& leaf = m_leaves[static_cast<std::size_t>(~child)];
      for_each_lane(find_near_boxes(leaf.boxes, local, best.squared_limit_m2, squared_m2), [&](std::size_t lane) {
        const int triangle = leaf.triangle[lane];
        if (squared_m2[lane] <= best.squared_limit_m2 && triangle != guess &&
            (left_out.empty() || !std::ranges::binary_search(left_out, triangle))) {
          consider(point, triangle, best);
        }
      });
      continue;
    }
    const Node& node = m_nodes[static_cast<std::size_t>(child)];
    const std::size_t first = waiting;  // the nearest one on top
    for_each_lane(find_near_boxes(node.boxes, local, best.squared_limit_m2, squared_m2), [&](std::size_t lane) {
      std::size_t at = waiting++;
      for (; at > first && stack[at - 1].squared_m2 < squared_m2[lane]; --at) {
        stack[at] = stack[at - 1];
      }
      stack[at] = {node.child[lane], squared_m2[lane]};
    });
  }
  if (best.triangle < 0) {
    return {};
  }
  return {best.found.point, std::sqrt(best.found.squared_distance_m2), best.triangle, best.found.feature};
}

/// Along the axis `along`, upwards or downwards; `right` and `up` are the other two, so that the three are right-handed
/// for a ray upwards.
struct MovingSurfaceTree::Ray {
  const Vec3& start;
  Eigen::Index along, right, up;
  bool upwards;
};

MovingSurfaceTree::Ray MovingSurfaceTree::shortest_ray_out(const Vec3& point) const {
  const Vec3 to_upper = m_box.max() - point;
  const Vec3 to_lower = point - m_box.min();
  Eigen::Index upper_axis = 0;
  Eigen::Index lower_axis = 0;
  const double upper_m = to_upper.minCoeff(&upper_axis);
  const double lower_m = to_lower.minCoeff(&lower_axis);
  const Eigen::Index axis = upper_m < lower_m ? upper_axis : lower_axis;
  return {point, axis, (axis + 1) % 3, (axis + 2) % 3, upper_m < lower_m};
}

/// +1 where the ray leaves through the triangle, -1 where it enters, 0 where it misses it.
int MovingSurfaceTree::crossing(const Ray& ray, int triangle) const {
  const Triangle& corners = m_triangles[static_cast<std::size_t>(triangle) - m_first_triangle];
  std::array<Vec3, 3> arms;  // seen from the start
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 arm = m_vertices[static_cast<std::size_t>(corners[i])] - ray.start;
    arms[i] = Vec3(arm[ray.along], arm[ray.right], arm[ray.up]);
  }
  const int turns = turns_about_line(arms);
  if (turns == 0) {
    return 0;
  }
  const Vec3 normal = (arms[1] - arms[0]).cross(arms[2] - arms[0]);
  const double ahead = normal.dot(arms[0]) * turns;  // sign: whether the plane is above or below the start
  if (ray.upwards ? !(ahead > 0) : !(ahead < 0)) {
    return 0;
  }
  return ray.upwards ? turns : -turns;
}

int MovingSurfaceTree::winding_number(const Vec3& point) const {
  if (!point.allFinite() || box_distance_m(point) > 0) {
    return 0;
  }
  const Ray ray = shortest_ray_out(point);
  const std::array<float, 3> local = to_boxes(point);
  const auto margin = static_cast<float>(margin_m(point) * (1 + float_slack));
  const auto axis = static_cast<int>(ray.along);
  int number = 0;
  std::array<std::int32_t, bvh_stack_capacity> stack;
  std::size_t waiting = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const std::int32_t child = stack[--waiting];
    if (child < 0) {
      const Leaf& leaf = m_leaves[static_cast<std::size_t>(~child)];
      for_each_lane(find_boxes_on_ray(leaf.boxes, local, axis, ray.upwards, margin),
                    [&](std::size_t lane) { number += crossing(ray, leaf.triangle[lane]); });
    } else {
      const Node& node = m_nodes[static_cast<std::size_t>(child)];
      for_each_lane(find_boxes_on_ray(node.boxes, local, axis, ray.upwards, margin),
                    [&](std::size_t lane) { stack[waiting++] = node.child[lane]; });
    }
  }
  return number;
}

double MovingSurfaceTree::box_distance_m(const Vec3& point) const {
  return std::max(m_box.exteriorDistance(point) * (1 - rounding) - m_travel_m, 0.0);
}

std::size_t MovingSurfaceTree::bytes() const {
  return m_nodes.capacity() * sizeof(Node) + m_leaves.capacity() * sizeof(Leaf) +
         m_triangles.capacity() * sizeof(Triangle) + m_fitted.capacity() * (sizeof(Vec3) + sizeof(m_fitted_local[0]));
}

}  // namespace musclebench
