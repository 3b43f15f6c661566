#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "core/bvh/bvh_lanes.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/bvh/triangle_bvh_nodes.hpp"
#include "core/distance/line_crossing.hpp"

namespace musclebench {

namespace {

/// A path as a frame for triangles: its longest coordinate is x, the other two are sheared along the path, so that the
/// path is the x axis (Woop et al. 2013). A corner gets the same coordinates in all triangles that share it.
class PathFrame {
 public:
  PathFrame(const Vec3& from, const Vec3& to) : m_from(from), m_displacement(to - from) {
    m_displacement.cwiseAbs().maxCoeff(&m_along);
    m_right = (m_along + 1) % 3;
    m_up = (m_along + 2) % 3;
  }

  [[nodiscard]] bool has_length() const { return std::abs(m_displacement[m_along]) > 0; }

  /// Whether the path passes through the triangle, into `found` but for its index.
  bool crosses(const std::array<Vec3, 3>& corners, PathCrossing& found) const {
    std::array<Vec3, 3> seen;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 arm = corners[i] - m_from;
      const double share = arm[m_along] / m_displacement[m_along];
      seen[i] =
          Vec3(arm[m_along], arm[m_right] - share * m_displacement[m_right], arm[m_up] - share * m_displacement[m_up]);
    }
    const int turns = turns_about_line(seen);
    if (turns == 0) {
      return false;
    }
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const double from_height = normal.dot(m_from - corners[0]);
    const double to_height = normal.dot(m_from + m_displacement - corners[0]);
    if ((from_height > 0) == (to_height > 0)) {
      return false;
    }
    found.share = from_height / (from_height - to_height);
    found.entering = (turns > 0) != (m_displacement[m_along] > 0);
    return true;
  }

 private:
  Vec3 m_from;
  Vec3 m_displacement;
  Eigen::Index m_along = 0, m_right = 1, m_up = 2;
};

}  // namespace

void TriangleBvh::find_crossings(const Vec3& from, const Vec3& to, std::vector<PathCrossing>& crossings) const {
  crossings.clear();
  const PathFrame path(from, to);
  if (m_nodes.empty() || !from.allFinite() || !to.allFinite() || !path.has_length()) {
    return;
  }
  BvhBox box;
  // All triangles are within 1 of the centre; a longer box would reach unused slots.
  const auto coordinate = [&](const Vec3& point, Eigen::Index i) {
    constexpr auto farthest = static_cast<double>(bvh_horizon);
    return std::clamp(m_scale * (point[i] - m_centre_m[i]), -farthest, farthest);
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const auto [low, high] = std::minmax({coordinate(from, i), coordinate(to, i)});
    box.lower[axis] = bvh_round_down(low) - bvh_box_padding;
    box.upper[axis] = bvh_round_up(high) + bvh_box_padding;
  }
  std::array<int, bvh_stack_capacity> stack;
  std::size_t waiting = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const int child = stack[--waiting];
    if (child >= 0) {
      const BvhNode& node = m_nodes[static_cast<std::size_t>(child)];
      for_each_lane(overlapping(box, node), [&](std::size_t lane) { stack[waiting++] = node.child[lane]; });
      continue;
    }
    const BvhLeaf& leaf = m_leaves[static_cast<std::size_t>(~child)];
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(leaf.count); ++lane) {
      PathCrossing found{.triangle = leaf.triangle[lane]};
      if (path.crosses(m_corners[static_cast<std::size_t>(found.triangle)], found)) {
        crossings.push_back(found);
      }
    }
  }
  std::ranges::sort(crossings, {},
                    [](const PathCrossing& crossing) { return std::tuple(crossing.share, crossing.triangle); });
}

}  // namespace musclebench
