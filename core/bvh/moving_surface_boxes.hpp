#pragma once

#include <array>
#include <cstdint>

#include "core/bvh/triangle_bvh_nodes.hpp"

namespace musclebench {

/// Eight axis-aligned boxes, one a lane, relative to the origin of their tree, in metres and single precision; unused
/// ones are inverted. Rounded to nearest; callers inflate the query by the rounding error.
struct alignas(32) MovingBoxes {
  std::array<BvhLanes, 3> lower;
  std::array<BvhLanes, 3> upper;
};

/// The lanes, a bit each, whose box is within `squared_limit_m2` of the point; and of all lanes the squared distance.
unsigned find_near_boxes(const MovingBoxes& boxes, const std::array<float, 3>& point, float squared_limit_m2,
                         BvhLanes& squared_m2);

/// The lanes whose box comes closer than `margin_m` to a ray from the point along `axis`, upwards or downwards.
unsigned find_boxes_on_ray(const MovingBoxes& boxes, const std::array<float, 3>& point, int axis, bool upwards,
                           float margin_m);

}  // namespace musclebench
