#include "core/bvh/moving_surface_boxes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/bvh/moving_surface_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/bvh/triangle_bvh_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

unsigned near_boxes(const MovingBoxes& boxes, const std::array<float, 3>& point, float squared_limit_m2,
                    BvhLanes& squared_m2) {
  const Lanes d;
  unsigned found = 0;
  for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
    Vec squared = hn::Zero(d);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Vec x = hn::Set(d, point[axis]);
      const Vec below = hn::Sub(load(boxes.lower[axis], first), x);
      const Vec above = hn::Sub(x, load(boxes.upper[axis], first));
      const Vec beyond = hn::Max(hn::Max(below, above), hn::Zero(d));
      squared = hn::MulAdd(beyond, beyond, squared);
    }
    hn::StoreU(squared, d, squared_m2.data() + first);
    found |= bits_of(d, hn::Le(squared, hn::Set(d, squared_limit_m2)), first);
  }
  return found;
}

unsigned boxes_on_ray(const MovingBoxes& boxes, const std::array<float, 3>& point, int axis, bool upwards,
                      float margin_m) {
  const Lanes d;
  const Vec margin = hn::Set(d, margin_m);
  unsigned found = 0;
  for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
    auto meets = hn::Eq(hn::Zero(d), hn::Zero(d));
    for (int i = 0; i < 3; ++i) {
      const auto a = static_cast<std::size_t>(i);
      const Vec x = hn::Set(d, point[a]);
      const auto is_above_lower = hn::Le(hn::Sub(load(boxes.lower[a], first), margin), x);
      const auto is_below_upper = hn::Ge(hn::Add(load(boxes.upper[a], first), margin), x);
      if (i != axis || !upwards) meets = hn::And(meets, is_above_lower);
      if (i != axis || upwards) meets = hn::And(meets, is_below_upper);
    }
    found |= bits_of(d, meets, first);
  }
  return found;
}

}  // namespace
}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(near_boxes);
HWY_EXPORT(boxes_on_ray);

unsigned find_near_boxes(const MovingBoxes& boxes, const std::array<float, 3>& point, float squared_limit_m2,
                         BvhLanes& squared_m2) {
  return HWY_DYNAMIC_DISPATCH(near_boxes)(boxes, point, squared_limit_m2, squared_m2);
}

unsigned find_boxes_on_ray(const MovingBoxes& boxes, const std::array<float, 3>& point, int axis, bool upwards,
                           float margin_m) {
  return HWY_DYNAMIC_DISPATCH(boxes_on_ray)(boxes, point, axis, upwards, margin_m);
}

}  // namespace musclebench
#endif
