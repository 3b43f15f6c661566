#pragma once

#include <array>
#include <bit>
#include <cstddef>

#include "core/bvh/triangle_bvh_nodes.hpp"

namespace musclebench {

/// More than the rounding error of a coordinate in the tree's frame, far less than a triangle.
inline constexpr float bvh_box_padding = 0x1p-22F;

/// An axis-aligned box in the tree's frame.
struct BvhBox {
  std::array<float, 3> lower;
  std::array<float, 3> upper;
};

/// One bit a lane: its box overlaps `box`. `Lanes` has `lower` and `upper` as BvhNode has.
template <typename Lanes>
unsigned overlapping(const BvhBox& box, const Lanes& lanes) {
  std::array<unsigned char, bvh_width> overlaps;
  overlaps.fill(1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t lane = 0; lane < bvh_width; ++lane) {
      overlaps[lane] = static_cast<unsigned char>(overlaps[lane] & (lanes.lower[axis][lane] <= box.upper[axis]) &
                                                  (lanes.upper[axis][lane] >= box.lower[axis]));
    }
  }
  unsigned bits = 0;
  for (std::size_t lane = 0; lane < bvh_width; ++lane) {
    bits |= static_cast<unsigned>(overlaps[lane]) << lane;
  }
  return bits;
}

/// Calls `visit(lane)` for each bit that is set.
template <typename Visit>
void for_each_lane(unsigned lanes, const Visit& visit) {
  for (; lanes != 0; lanes &= lanes - 1) visit(static_cast<std::size_t>(std::countr_zero(lanes)));
}

}  // namespace musclebench
