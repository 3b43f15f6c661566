#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/bvh/triangle_bvh.hpp"
#include "core/bvh/triangle_bvh_nodes.hpp"
#include "core/distance/solid_angle_sum.hpp"

namespace musclebench {

namespace {

/// A closed surface has integer winding numbers; a sum this close to 0.5 shows that the dipoles were too coarse.
constexpr double safe_margin = 0.25;

}  // namespace

double TriangleBvh::leaf_winding(const BvhLeaf& leaf, const Vec3& point) const {
  SolidAngleSum angles(point);
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(leaf.count); ++lane) {
    const auto& [a, b, c] = m_corners[static_cast<std::size_t>(leaf.triangle[lane])];
    angles.add(a, b, c);
  }
  return angles.winding_number();
}

double TriangleBvh::winding_number(const Vec3& point, double opening) const {
  double winding = 0;
  std::array<int, bvh_stack_capacity> stack;
  int top = 0;
  stack[0] = 0;
  while (top >= 0) {
    const auto index = static_cast<std::size_t>(stack[static_cast<std::size_t>(top--)]);
    const BvhNode& node = m_nodes[index];
    for (std::size_t part = 0; part < bvh_width && node.lower[0][part] <= node.upper[0][part]; ++part) {
      const BvhCluster& cluster = m_clusters[index][part];
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

double TriangleBvh::winding_number(const Vec3& point) const {
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

}  // namespace musclebench
