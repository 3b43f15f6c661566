#include <algorithm>
#include <array>
#include <cstddef>

#include "core/bvh/bvh_lanes.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/bvh/triangle_bvh_nodes.hpp"

namespace musclebench {

namespace {

struct LaneBoxes {
  std::array<BvhLanes, 3> lower;
  std::array<BvhLanes, 3> upper;
};

BvhBox box_at(const LaneBoxes& boxes, std::size_t lane) {
  BvhBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lower[axis] = boxes.lower[axis][lane];
    box.upper[axis] = boxes.upper[axis][lane];
  }
  return box;
}

BvhBox bounds_of(const LaneBoxes& boxes) {
  BvhBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lower[axis] = *std::min_element(boxes.lower[axis].begin(), boxes.lower[axis].end());
    box.upper[axis] = *std::max_element(boxes.upper[axis].begin(), boxes.upper[axis].end());
  }
  return box;
}

}  // namespace

void TriangleBvh::for_each_close_pair(const std::function<void(int, int)>& visit) const {
  std::vector<LaneBoxes> boxes(m_leaves.size());
  for (std::size_t index = 0; index < m_leaves.size(); ++index) {
    for (std::size_t lane = 0; lane < bvh_width; ++lane) {
      const bool used = lane < static_cast<std::size_t>(m_leaves[index].count);
      const auto& corners = m_corners[static_cast<std::size_t>(used ? m_leaves[index].triangle[lane] : 0)];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto own = [&](std::size_t corner) {
          const auto i = static_cast<Eigen::Index>(axis);
          return static_cast<float>(m_scale * (corners[corner][i] - m_centre_m[i]));
        };
        boxes[index].lower[axis][lane] = used ? std::min({own(0), own(1), own(2)}) - bvh_box_padding : bvh_far_away;
        boxes[index].upper[axis][lane] = used ? std::max({own(0), own(1), own(2)}) + bvh_box_padding : -bvh_far_away;
      }
    }
  }
  for (std::size_t index = 0; index < m_leaves.size(); ++index) {
    const BvhBox bounds = bounds_of(boxes[index]);
    const auto visit_leaf = [&](std::size_t other) {
      for_each_lane(overlapping(bounds, boxes[other]), [&](std::size_t theirs) {
        const unsigned mine = overlapping(box_at(boxes[other], theirs), boxes[index]);
        // Within one leaf only lower lanes, so that each pair is visited once.
        for_each_lane(other == index ? mine & ((1U << theirs) - 1U) : mine, [&](std::size_t lane) {
          visit(m_leaves[index].triangle[lane], m_leaves[other].triangle[theirs]);
        });
      });
    };
    std::array<int, bvh_stack_capacity> stack;
    int top = 0;
    stack[0] = 0;
    while (top >= 0) {
      const BvhNode& node = m_nodes[static_cast<std::size_t>(stack[static_cast<std::size_t>(top--)])];
      for_each_lane(overlapping(bounds, node), [&](std::size_t part) {
        const int child = node.child[part];
        if (child >= 0) {
          stack[static_cast<std::size_t>(++top)] = child;
        } else if (static_cast<std::size_t>(~child) >= index) {
          visit_leaf(static_cast<std::size_t>(~child));
        }
      });
    }
  }
}

}  // namespace musclebench
