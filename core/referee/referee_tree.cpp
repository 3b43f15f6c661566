#include "core/referee/referee_tree.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/referee/referee_sign.hpp"
#include "core/referee/referee_tree_builder.hpp"

namespace musclebench {
namespace {

/// 32-bit boxes and points carry relative errors of 2^-24 an operation; this covers the few of them in a box distance.
constexpr double float_slack = 0x1p-20;

struct StackEntry {
  float squared_distance;
  int child;
};

/// The tree's depth is bounded by its builder, and a visited node leaves at most three children waiting.
constexpr int stack_size = 4 * RefereeTreeBuilder::depth_limit;

void keep_nearer(const Vec3& query, const Vec3& point, double& squared, Vec3& nearest) {
  const double candidate = (query - point).squaredNorm();
  if (candidate < squared) {
    squared = candidate;
    nearest = point;
  }
}

void keep_nearer_of_edge(const Vec3& query, const Vec3& from, const Vec3& to, double& squared, Vec3& nearest) {
  const Vec3 edge = to - from;
  const double along = (query - from).dot(edge);
  const double whole = edge.squaredNorm();
  // The ends are taken as they are, so that all triangles around a vertex give the very same distance.
  if (along <= 0) return keep_nearer(query, from, squared, nearest);
  if (along >= whole) return keep_nearer(query, to, squared, nearest);
  keep_nearer(query, from + (along / whole) * edge, squared, nearest);
}

}  // namespace

RefereeTree::RefereeTree(const TriangleMesh& mesh) { RefereeTreeBuilder(mesh, *this).build(); }

void RefereeTree::refit(std::span<const Triangle> triangles, std::span<const Vec3> vertices) {
  RefereeTreeBuilder::refit(triangles, vertices, *this);
}

double RefereeTree::box_distance(const Vec3& point) const {
  return (point.cwiseAbs() - m_half_extents).cwiseMax(0.0).norm();
}

Vec3 RefereeTree::face_normal(int slot) const {
  const Corners& triangle = m_triangles[static_cast<std::size_t>(slot)];
  const Vec3 normal = (triangle.b - triangle.a).cross(triangle.c - triangle.a);
  const double length = normal.norm();
  return length > 0 ? Vec3(normal / length) : Vec3(Vec3::Zero());
}

void RefereeTree::consider(const Vec3& point, int slot, ClosestSurfacePoint& best) const {
  const Corners& t = m_triangles[static_cast<std::size_t>(slot)];
  const Vec3 ab = t.b - t.a;
  const Vec3 ac = t.c - t.a;
  const Vec3 normal = ab.cross(ac);
  const Vec3 to_point = point - t.a;
  // Barycentric weights of the foot on the triangle's plane, times whole = (twice the area)^2.
  const double whole = normal.squaredNorm();
  const double weight_b = to_point.cross(ac).dot(normal);
  const double weight_c = ab.cross(to_point).dot(normal);
  const double weight_a = whole - weight_b - weight_c;

  double squared = std::numeric_limits<double>::infinity();
  Vec3 nearest = t.a;
  const bool over_face = whole > 0 && weight_a >= 0 && weight_b >= 0 && weight_c >= 0;
  if (over_face) {
    double share_b = weight_b / whole;
    double share_c = weight_c / whole;
    Vec3 foot = t.a + share_b * ab + share_c * ac;
    if (t.sliver) {
      // The weights of a thin triangle are poor; one step on the residual squares their relative error.
      const Vec3 residual = point - foot;
      share_b = std::clamp(share_b + residual.cross(ac).dot(normal) / whole, 0.0, 1.0);
      share_c = std::clamp(share_c + ab.cross(residual).dot(normal) / whole, 0.0, 1.0 - share_b);
      foot = t.a + share_b * ab + share_c * ac;
    }
    keep_nearer(point, foot, squared, nearest);
  }
  // The closest point of a convex outline lies on an edge that faces the point.
  if (t.sliver || weight_c < 0) keep_nearer_of_edge(point, t.a, t.b, squared, nearest);
  if (t.sliver || weight_a < 0) keep_nearer_of_edge(point, t.b, t.c, squared, nearest);
  if (t.sliver || weight_b < 0) keep_nearer_of_edge(point, t.c, t.a, squared, nearest);

  const bool first = best.slot < 0;
  const bool tie = squared == best.squared_distance_m2;
  if (first || squared < best.squared_distance_m2 ||
      (tie && t.index < m_triangles[static_cast<std::size_t>(best.slot)].index)) {
    best = {squared, nearest, slot};
  }
}

ClosestSurfacePoint RefereeTree::closest(const Vec3& point, int guess, long* work) const {
  ClosestSurfacePoint best;
  if (guess >= 0) consider(point, guess, best);
  const Eigen::Array3f query = point.cast<float>().array();
  const double slack = float_slack * (point.lpNorm<Eigen::Infinity>() + m_half_extents.sum());
  const auto bound_of = [&](double squared) {
    const double bound = std::sqrt(squared) * (1 + float_slack) + slack;
    return static_cast<float>(bound * bound * (1 + float_slack));
  };
  float bound = bound_of(best.squared_distance_m2);

  std::array<StackEntry, stack_size> stack;
  long steps = 0;
  int waiting = 0;
  stack[waiting++] = {0, 0};
  while (waiting > 0) {
    const StackEntry entry = stack[--waiting];
    if (entry.squared_distance > bound) continue;
    ++steps;
    if (entry.child < 0) {
      const int leaf = ~entry.child;
      steps += leaf % 8;
      for (int slot = leaf / 8; slot < leaf / 8 + leaf % 8; ++slot) consider(point, slot, best);
      bound = bound_of(best.squared_distance_m2);
      continue;
    }
    const Node& node = m_nodes[static_cast<std::size_t>(entry.child)];
    Eigen::Array4f squared = Eigen::Array4f::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      squared += (node.low[axis] - query[axis]).max(query[axis] - node.high[axis]).max(0.0F).square();
    }
    // The nearest child last, so that it is the next to be visited.
    const int first = waiting;
    for (int k = 0; k < 4; ++k) {
      if (!(squared[k] <= bound) || !(squared[k] < std::numeric_limits<float>::infinity())) continue;
      int at = waiting++;
      for (; at > first && stack[at - 1].squared_distance < squared[k]; --at) stack[at] = stack[at - 1];
      stack[at] = {squared[k], node.child[k]};
    }
  }
  add_work(work, steps);
  return best;
}

/// The ray that leaves the box soonest meets the fewest triangles.
AxisRay RefereeTree::shortest_ray_out(const Vec3& point) const {
  AxisRay ray;
  (m_half_extents - point.cwiseAbs()).minCoeff(&ray.axis);
  ray.upwards = point[ray.axis] > 0;
  return ray;
}

int RefereeTree::count_crossings(const Vec3& point, AxisRay ray, long* work) const {
  const int i = (ray.axis + 1) % 3;
  const int j = (ray.axis + 2) % 3;
  const Eigen::Array3f below = point.unaryExpr([](double x) { return round_down(x); }).array();
  const Eigen::Array3f above = point.unaryExpr([](double x) { return round_up(x); }).array();

  int crossings = 0;
  long steps = 0;
  std::array<int, stack_size> stack;
  int waiting = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const int child = stack[--waiting];
    ++steps;
    if (child < 0) {
      const int leaf = ~child;
      steps += leaf % 8;
      for (int slot = leaf / 8; slot < leaf / 8 + leaf % 8; ++slot) {
        const Corners& t = m_triangles[static_cast<std::size_t>(slot)];
        crossings += ray_crossing(t.a, t.b, t.c, point, ray);
      }
      continue;
    }
    const Node& node = m_nodes[static_cast<std::size_t>(child)];
    Eigen::Array4f gap = (node.low[i] - above[i]).max(below[i] - node.high[i]);
    gap = gap.max(node.low[j] - above[j]).max(below[j] - node.high[j]);
    gap = gap.max(ray.upwards ? Eigen::Array4f(below[ray.axis] - node.high[ray.axis])
                              : Eigen::Array4f(node.low[ray.axis] - above[ray.axis]));
    for (int k = 0; k < 4; ++k) {
      if (gap[k] <= 0) stack[waiting++] = node.child[k];
    }
  }
  add_work(work, steps);
  return crossings;
}

double RefereeTree::winding_number(const Vec3& point, long* work) const {
  const bool outside_box = box_distance(point) > 0;
  if (closed() && outside_box) return 0;
  const AxisRay ray = shortest_ray_out(point);
  double number = outside_box ? 0 : count_crossings(point, ray, work);
  add_work(work, static_cast<long>(m_boundary.size()));
  for (const BoundaryEdge& edge : m_boundary) number += edge.uses * strip_share(edge.from, edge.to, point, ray);
  return number;
}

/// The bound of the movement is derived in reports/performance/winding_number_bound.md.
SurfaceWinding RefereeTree::winding(const Vec3& point, long* work) const {
  SurfaceWinding winding{winding_number(point, work)};
  if (closed()) return winding;
  add_work(work, static_cast<long>(m_boundary.size()));
  double nearest = std::numeric_limits<double>::infinity();
  double linear = 0;
  double quadratic = 0;
  for (const BoundaryEdge& edge : m_boundary) {
    double squared = std::numeric_limits<double>::infinity();
    Vec3 foot = edge.from;
    keep_nearer_of_edge(point, edge.from, edge.to, squared, foot);
    nearest = std::min(nearest, squared);
    linear += edge.uses * (edge.to - edge.from).norm() / squared;
    quadratic += edge.uses * 2 / squared;
  }
  const double margin = std::numbers::pi * std::abs(winding.number - 0.5);
  const double reach = 2 * margin / (linear + std::sqrt(linear * linear + 4 * quadratic * margin));
  // On the boundary itself the sums are infinite and the quotient is no number: nothing holds there.
  winding.steady_m = reach > 0 ? std::min(reach, 0.5 * std::sqrt(nearest)) : 0;
  return winding;
}

std::size_t RefereeTree::bytes() const {
  return m_triangles.capacity() * sizeof(Corners) + m_nodes.capacity() * sizeof(Node) +
         m_boundary.capacity() * sizeof(BoundaryEdge);
}

}  // namespace musclebench
