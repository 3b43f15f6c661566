#include <algorithm>
#include <array>
#include <cmath>

#include "core/referee/referee_sign.hpp"
#include "core/referee/referee_tree.hpp"
#include "core/referee/referee_tree_builder.hpp"

namespace musclebench {
namespace {

constexpr int crossing_stack_size = 4 * RefereeTreeBuilder::depth_limit;
/// Covers the rounding of 32-bit boxes and products, relative to the coordinates.
constexpr float crossing_slack = 0x1p-20F;
/// Covers the rounding of a determinant, relative to its largest product.
constexpr double determinant_rounding = 0x1p-46;

/// Part of a line, as one coordinate of its points.
struct Interval {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void extend(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
};

/// Where a triangle cuts a plane: `x` is a coordinate of its corners, `height` their height over the plane.
Interval cut(const Vec3& x, const Vec3& height) {
  Interval result;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (height[i] == 0) result.extend(x[i]);
    if (height[i] * height[j] < 0) {
      result.extend(x[i] + (x[j] - x[i]) * (height[i] / (height[i] - height[j])));
    }
  }
  return result;
}

/// A triangle that many are tested against.
struct QueryTriangle {
  Vec3 a, b, c;
  Vec3 normal;  ///< its length is twice the area

  QueryTriangle(const Vec3& corner_a, const Vec3& corner_b, const Vec3& corner_c)
      : a(corner_a), b(corner_b), c(corner_c), normal((b - a).cross(c - a)) {}
};

/// Heights that rounding may have moved off the plane are put on it. False: all three lie clearly on one side.
bool reaches_plane(Vec3& heights, double slack) {
  if (heights.minCoeff() > slack || heights.maxCoeff() < -slack) return false;
  heights = heights.unaryExpr([slack](double height) { return std::abs(height) <= slack ? 0 : height; });
  return true;
}

/// Moeller 1997: two triangles that each reach the other's plane cut the common line of the planes in two intervals.
bool triangles_meet(const QueryTriangle& query, const Vec3& p, const Vec3& q, const Vec3& r) {
  const double size = std::max((p - query.a).lpNorm<Eigen::Infinity>(), (q - p).lpNorm<Eigen::Infinity>()) +
                      std::max((r - p).lpNorm<Eigen::Infinity>(), (query.b - query.a).lpNorm<Eigen::Infinity>()) +
                      (query.c - query.a).lpNorm<Eigen::Infinity>();
  Vec3 heights(query.normal.dot(p - query.a), query.normal.dot(q - query.a), query.normal.dot(r - query.a));
  if (!reaches_plane(heights, determinant_rounding * size * size * size)) return false;
  const QueryTriangle other(p, q, r);
  Vec3 heights_of_query(other.normal.dot(query.a - p), other.normal.dot(query.b - p), other.normal.dot(query.c - p));
  if (!reaches_plane(heights_of_query, determinant_rounding * size * size * size)) return false;
  if (heights.isZero(0) || heights_of_query.isZero(0)) return true;  // in one plane, or without area
  int axis = 0;
  query.normal.cross(other.normal).cwiseAbs().maxCoeff(&axis);
  const Interval one = cut({p[axis], q[axis], r[axis]}, heights);
  const Interval two = cut({query.a[axis], query.b[axis], query.c[axis]}, heights_of_query);
  const double slack = determinant_rounding * (size + std::abs(p[axis]));
  return one.low <= two.high + slack && two.low <= one.high + slack;
}

/// A box in 32 bits, rounded outwards.
struct FloatBox {
  Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity());
  Eigen::Array3f high = Eigen::Array3f::Constant(-std::numeric_limits<float>::infinity());

  void extend(const Vec3& point) {
    low = low.min(point.unaryExpr([](double x) { return round_down(x); }).cast<float>().array());
    high = high.max(point.unaryExpr([](double x) { return round_up(x); }).cast<float>().array());
  }
};

/// Which children of a node of the tree the box touches.
template <typename Node>
Eigen::Array<bool, 4, 1> reaches(const Node& node, const FloatBox& box) {
  Eigen::Array4f gap = (node.low[0] - box.high[0]).max(box.low[0] - node.high[0]);
  gap = gap.max(node.low[1] - box.high[1]).max(box.low[1] - node.high[1]);
  gap = gap.max(node.low[2] - box.high[2]).max(box.low[2] - node.high[2]);
  return Eigen::Array<bool, 4, 1>(gap <= 0);
}

}  // namespace

template <typename Filter, typename Visit>
void RefereeTree::visit(const Filter& may_matter, const Visit& visit_slot, long* work) const {
  long steps = 0;
  std::array<int, crossing_stack_size> stack;
  int waiting = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const int child = stack[--waiting];
    ++steps;
    if (child < 0) {
      const int leaf = ~child;
      bool goes_on = true;
      for (int slot = leaf / 8; goes_on && slot < leaf / 8 + leaf % 8; ++slot) {
        ++steps;
        goes_on = visit_slot(slot);
      }
      if (!goes_on) break;
      continue;
    }
    const Node& node = m_nodes[static_cast<std::size_t>(child)];
    const Eigen::Array<bool, 4, 1> wanted = may_matter(node);
    for (int k = 0; k < 4; ++k) {
      if (wanted[k]) stack[waiting++] = node.child[k];
    }
  }
  add_work(work, steps);
}

int RefereeTree::find_touched(const Vec3& a, const Vec3& b, const Vec3& c, long* work) const {
  const QueryTriangle query(a, b, c);
  FloatBox box;
  for (const Vec3* corner : {&a, &b, &c}) box.extend(*corner);
  const double length = query.normal.norm();
  const Eigen::Array3f normal = length > 0 ? Eigen::Array3f((query.normal / length).cast<float>()) : Eigen::Array3f(0);
  const float height = normal.matrix().dot(a.cast<float>());
  const auto slack = static_cast<float>(m_half_extents.sum() + a.lpNorm<1>()) * crossing_slack;
  const auto may_matter = [&](const Node& node) {
    Eigen::Array4f gap = (node.low[0] - box.high[0]).max(box.low[0] - node.high[0]);
    gap = gap.max(node.low[1] - box.high[1]).max(box.low[1] - node.high[1]);
    gap = gap.max(node.low[2] - box.high[2]).max(box.low[2] - node.high[2]);
    // The box's own extent across the triangle's plane. NaN (0 times infinity) of an absent child fails, as it should.
    Eigen::Array4f lowest = Eigen::Array4f::Constant(-height - slack);
    Eigen::Array4f highest = Eigen::Array4f::Constant(-height + slack);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Array4f one = normal[axis] * node.low[axis];
      const Eigen::Array4f other = normal[axis] * node.high[axis];
      lowest += one.min(other);
      highest += one.max(other);
    }
    return Eigen::Array<bool, 4, 1>(gap <= 0 && lowest <= 0 && highest >= 0);
  };
  int met = -1;
  visit(
      may_matter,
      [&](int slot) {
        const Corners& t = m_triangles[static_cast<std::size_t>(slot)];
        if (triangles_meet(query, t.a, t.b, t.c)) met = slot;
        return met < 0;
      },
      work);
  return met;
}

void RefereeTree::find_near_box(const Eigen::AlignedBox3d& near, std::vector<int>& triangles, long* work) const {
  triangles.clear();
  FloatBox box;
  box.extend(near.min());
  box.extend(near.max());
  visit([&](const Node& node) { return reaches(node, box); },
        [&](int slot) {
          triangles.push_back(triangle_index(slot));
          return true;
        },
        work);
}

void RefereeTree::cross(const Vec3& from, const Vec3& to, std::vector<SurfaceCrossing>& crossings, long* work) const {
  crossings.clear();
  FloatBox box;
  box.extend(from);
  box.extend(to);
  visit([&](const Node& node) { return reaches(node, box); },
        [&](int slot) {
          const Corners& t = m_triangles[static_cast<std::size_t>(slot)];
          const int crossing = segment_crossing(t.a, t.b, t.c, from, to);
          if (crossing != 0) {
            const Vec3 normal = (t.b - t.a).cross(t.c - t.a);
            const double start = std::abs(normal.dot(from - t.a));
            const double end = std::abs(normal.dot(to - t.a));
            crossings.push_back({start + end > 0 ? start / (start + end) : 0, crossing < 0, slot});
          }
          return true;
        },
        work);
  std::sort(crossings.begin(), crossings.end(), [&](const SurfaceCrossing& one, const SurfaceCrossing& other) {
    return std::pair(one.share, triangle_index(one.slot)) < std::pair(other.share, triangle_index(other.slot));
  });
}

}  // namespace musclebench
