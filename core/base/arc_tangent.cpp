#include "core/base/arc_tangent.hpp"

#include <hwy/highway.h>

#include "core/base/arc_tangent-inl.hpp"

namespace musclebench {

double arc_tangent2(double y, double x) {
  const hwy::HWY_NAMESPACE::CappedTag<double, 1> d;
  return hwy::HWY_NAMESPACE::GetLane(
      HWY_NAMESPACE::arc_tangent2(d, hwy::HWY_NAMESPACE::Set(d, y), hwy::HWY_NAMESPACE::Set(d, x)));
}

}  // namespace musclebench
