#include "core/effects/no_passage/triangle_axes.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/effects/no_passage/triangle_axes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/bvh/triangle_bvh_lanes-inl.hpp"
#include "core/effects/no_passage/sphere_lanes.hpp"

#ifndef MUSCLEBENCH_TRIANGLE_AXES_TYPES
#define MUSCLEBENCH_TRIANGLE_AXES_TYPES
namespace musclebench {

/// Corners of two triangles, in single precision.
struct SixPoints {
  std::array<std::array<float, 4>, 6> at;  ///< the last number is not used
};
struct alignas(32) EightAxes {
  std::array<BvhLanes, 3> along;
};

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

/// Of triangles as large as 1: its square is far from what single precision can't tell from 0.
constexpr float shortest_axis = 1e-15F;

struct Gaps {
  Vec above;  ///< how far the first is above the second
  Vec below;
};

HWY_INLINE Gaps gaps_along(const Vec3Lanes& axis, const SixPoints& points) {
  const auto along = [&](std::size_t k) HWY_ATTR {
    return dot(axis, splat({points.at[k][0], points.at[k][1], points.at[k][2]}));
  };
  const Vec a = along(0);
  const Vec b = along(1);
  const Vec c = along(2);
  const Vec d = along(3);
  const Vec e = along(4);
  const Vec f = along(5);
  const Vec first_least = hn::Min(a, hn::Min(b, c));
  const Vec first_most = hn::Max(a, hn::Max(b, c));
  const Vec second_least = hn::Min(d, hn::Min(e, f));
  const Vec second_most = hn::Max(d, hn::Max(e, f));
  return {hn::Sub(first_least, second_most), hn::Sub(second_least, first_most)};
}

/// The greatest gap at the start, and whether a gap is greater than `least_m` at both ends.
float apart(const EightAxes& axes, const SixPoints& start, const SixPoints& end, float least_m, bool& stay_apart) {
  const Lanes d;
  Vec most = hn::Zero(d);
  stay_apart = false;
  for (std::size_t from = 0; from < bvh_width; from += hn::Lanes(d)) {
    const Vec3Lanes axis = load(axes.along, from);
    const Vec length = hn::Sqrt(dot(axis, axis));
    const Vec inverse =
        hn::IfThenElseZero(hn::Gt(length, hn::Set(d, shortest_axis)), hn::Div(hn::Set(d, 1.0F), length));
    const Gaps before = gaps_along(axis, start);
    const Gaps after = gaps_along(axis, end);
    most = hn::Max(most, hn::Mul(inverse, hn::Max(before.above, before.below)));
    // Of linear functions of time the least is concave and the greatest convex: a gap at both ends is one between.
    const Vec least = hn::Set(d, least_m);
    const Vec above = hn::Mul(inverse, hn::Min(before.above, after.above));
    const Vec below = hn::Mul(inverse, hn::Min(before.below, after.below));
    stay_apart = stay_apart || !hn::AllFalse(d, hn::Gt(hn::Max(above, below), least));
  }
  return hn::GetLane(hn::MaxOfLanes(d, most));
}

}  // namespace
}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

namespace {
HWY_EXPORT(apart);

std::array<float, 3> cross(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
}  // namespace

ApartAlongAxes apart_along_axes(const TrianglePath& first, const TrianglePath& second, double least_m) {
  std::array<Four, 6> from;
  std::array<Four, 6> to;
  Four largest = Four::Zero();
  Four extent = Four::Zero();
  for (std::size_t k = 0; k < 6; ++k) {
    const VertexPath& of = *(k < 3 ? first : second)[k % 3];
    from[k] = of.from - first[0]->from;
    to[k] = from[k] + of.move;
    extent = extent.max(from[k].abs()).max(to[k].abs());
    largest = largest.max(of.from.abs());
  }
  // As large as 1, so that no product leaves the range of single precision.
  const float scale_m = extent.maxCoeff();
  if (!(scale_m > std::numeric_limits<float>::min())) return {};
  const float to_one = 1 / scale_m;
  SixPoints at_start;
  SixPoints at_end;
  for (std::size_t k = 0; k < 6; ++k) {
    Eigen::Map<Four>(at_start.at[k].data()) = to_one * from[k];
    Eigen::Map<Four>(at_end.at[k].data()) = to_one * to[k];
  }
  EightAxes axes;
  const auto set = [&](std::size_t lane, const std::array<float, 3>& axis) {
    for (std::size_t i = 0; i < 3; ++i) axes.along[i][lane] = axis[i];
  };
  for (std::size_t side = 0; side < 2; ++side) {
    std::array<std::array<float, 3>, 3> edges;
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < 3; ++i)
        edges[k][i] = at_start.at[3 * side + (k + 1) % 3][i] - at_start.at[3 * side + k][i];
    }
    const std::array<float, 3> normal = cross(edges[0], edges[1]);
    set(4 * side, normal);
    for (std::size_t k = 0; k < 3; ++k) set(4 * side + 1 + k, cross(edges[k], normal));
  }
  const float rounding_of_it = 2 * lane_rounding * (1 + to_one * largest.maxCoeff());
  ApartAlongAxes result;
  const float start = HWY_DYNAMIC_DISPATCH(apart)(
      axes, at_start, at_end, to_one * static_cast<float>(least_m) + rounding_of_it, result.stay_apart);
  result.start_m = scale_m * std::max(0.0F, start - rounding_of_it);
  return result;
}

}  // namespace musclebench
#endif
