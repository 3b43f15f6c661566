#include <algorithm>
#include <array>
#include <cstddef>

#include "core/bvh/triangle_bvh.hpp"

namespace musclebench {

namespace {

constexpr int stack_capacity = 320;
/// More than the rounding of a coordinate to float, in the tree's own unit, and far less than a triangle.
constexpr float padding = 0x1p-22F;

struct LaneBoxes {
  std::array<BvhLanes, 3> lower;
  std::array<BvhLanes, 3> upper;
};

struct FloatBox {
  std::array<float, 3> lower;
  std::array<float, 3> upper;
};

/// A bit a place whose box meets `box`.
template <typename Lanes>
unsigned meeting(const FloatBox& box, const Lanes& lanes) {
  std::array<unsigned char, bvh_width> meets;
  meets.fill(1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t place = 0; place < bvh_width; ++place) {
      meets[place] = static_cast<unsigned char>(meets[place] & (lanes.lower[axis][place] <= box.upper[axis]) &
                                                (lanes.upper[axis][place] >= box.lower[axis]));
    }
  }
  unsigned bits = 0;
  for (std::size_t place = 0; place < bvh_width; ++place) {
    bits |= static_cast<unsigned>(meets[place]) << place;
  }
  return bits;
}

template <typename Visit>
void for_each_bit(unsigned bits, Visit&& visit) {
  for (std::size_t place = 0; bits != 0; ++place, bits >>= 1U) {
    if ((bits & 1U) != 0) {
      visit(place);
    }
  }
}

FloatBox box_at(const LaneBoxes& boxes, std::size_t place) {
  FloatBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lower[axis] = boxes.lower[axis][place];
    box.upper[axis] = boxes.upper[axis][place];
  }
  return box;
}

FloatBox box_about(const LaneBoxes& boxes) {
  FloatBox box;
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
    for (std::size_t place = 0; place < bvh_width; ++place) {
      const bool used = place < static_cast<std::size_t>(m_leaves[index].count);
      const auto& corners = m_corners[static_cast<std::size_t>(used ? m_leaves[index].triangle[place] : 0)];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto own = [&](std::size_t corner) {
          const auto i = static_cast<Eigen::Index>(axis);
          return static_cast<float>(m_scale * (corners[corner][i] - m_centre_m[i]));
        };
        boxes[index].lower[axis][place] = used ? std::min({own(0), own(1), own(2)}) - padding : bvh_far_away;
        boxes[index].upper[axis][place] = used ? std::max({own(0), own(1), own(2)}) + padding : -bvh_far_away;
      }
    }
  }
  for (std::size_t index = 0; index < m_leaves.size(); ++index) {
    const FloatBox about = box_about(boxes[index]);
    const auto look = [&](std::size_t other) {
      for_each_bit(meeting(about, boxes[other]), [&](std::size_t theirs) {
        const unsigned mine = meeting(box_at(boxes[other], theirs), boxes[index]);
        // Within one leaf each pair once.
        for_each_bit(other == index ? mine & ((1U << theirs) - 1U) : mine, [&](std::size_t place) {
          visit(m_leaves[index].triangle[place], m_leaves[other].triangle[theirs]);
        });
      });
    };
    std::array<int, stack_capacity> stack;
    int top = 0;
    stack[0] = 0;
    while (top >= 0) {
      const BvhNode& node = m_nodes[static_cast<std::size_t>(stack[static_cast<std::size_t>(top--)])];
      for_each_bit(meeting(about, node), [&](std::size_t part) {
        const int child = node.child[part];
        if (child >= 0) {
          stack[static_cast<std::size_t>(++top)] = child;
        } else if (static_cast<std::size_t>(~child) >= index) {
          look(static_cast<std::size_t>(~child));
        }
      });
    }
  }
}

}  // namespace musclebench
