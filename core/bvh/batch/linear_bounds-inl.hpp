// Linear bounds of squared distances, for all points of a box at once. Included by each file that is compiled once for
// every kind of SIMD, after highway.h.
#if defined(MUSCLEBENCH_LINEAR_BOUNDS) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_LINEAR_BOUNDS
#undef MUSCLEBENCH_LINEAR_BOUNDS
#else
#define MUSCLEBENCH_LINEAR_BOUNDS
#endif

#include <cmath>
#include <cstddef>

#include <hwy/highway.h>

#include "core/bvh/batch/bound_list.hpp"
#include "core/bvh/triangle_bvh_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro

// Linear bounds of the squared distance to a convex set, for all points of a box; derived, with their rounding errors,
// in reports/performance/batched_closest_point.md. r is the query point less the middle of the box.

/// From below: squared distance - r^2 >= value + slope * r.
struct Bound {
  Vec value;
  Vec3Lanes slope;
};

/// How far the bounds of a box may be off: `share` times the sum of the coordinates of w, and `fixed` more.
struct BoundErrors {
  float share;
  float fixed;
  float reach;  ///< of the box from its middle

  BoundErrors(const BvhView& bvh, const QueryBox& box)
      : share(8 * bvh.slack),
        fixed(0),
        reach(1.000001F *
              std::sqrt(box.half[0] * box.half[0] + box.half[1] * box.half[1] + box.half[2] * box.half[2])) {
    // The axes of an OBB are a little short.
    fixed = bvh.slack * (10 * (reach + bvh.longest_side) + 20 * bvh.slack) + 5e-6F * reach * reach;
  }
};

HWY_INLINE Vec sum_of_sizes(const Vec3Lanes& a) { return hn::Add(hn::Add(hn::Abs(a.x), hn::Abs(a.y)), hn::Abs(a.z)); }

HWY_INLINE Vec less_errors(Vec value, const Vec3Lanes& out, const BoundErrors& errors) {
  const Lanes d;
  return hn::Sub(hn::NegMulAdd(hn::Set(d, errors.share), sum_of_sizes(out), value), hn::Set(d, errors.fixed));
}

/// One axis of a box.
struct Interval {
  Vec out;    ///< from the nearest value to the middle
  Vec value;  ///< out^2 - k

  HWY_INLINE Interval(Vec middle, Vec half, Vec lower, Vec upper) {
    const Vec nearest = hn::Min(hn::Max(middle, lower), upper);
    out = hn::Sub(middle, nearest);
    const Vec reach = hn::Max(hn::Sub(half, hn::Abs(out)), hn::Zero(Lanes()));
    const Vec extent = hn::Min(reach, hn::Max(hn::Sub(upper, nearest), hn::Sub(nearest, lower)));
    value = hn::NegMulAdd(extent, hn::Sub(hn::Add(reach, reach), extent), hn::Mul(out, out));
  }
};

HWY_INLINE Vec3Lanes abs(const Vec3Lanes& a) { return {hn::Abs(a.x), hn::Abs(a.y), hn::Abs(a.z)}; }

HWY_INLINE Bound bound_of_children(const BvhNode& node, const Vec3Lanes& middle, const Vec3Lanes& half,
                                   const BoundErrors& errors, std::size_t first) {
  const Interval x(middle.x, half.x, load(node.lower[0], first), load(node.upper[0], first));
  const Interval y(middle.y, half.y, load(node.lower[1], first), load(node.upper[1], first));
  const Interval z(middle.z, half.z, load(node.lower[2], first), load(node.upper[2], first));
  const Vec value = hn::Add(hn::Add(x.value, y.value), z.value);
  const Vec3Lanes normal = load(node.normal, first);
  const Vec3Lanes tangent = load(node.tangent, first);
  const Vec3Lanes third = cross(normal, tangent);
  const Interval up(dot(normal, middle), dot(abs(normal), half), load(node.obb_lower[0], first),
                    load(node.obb_upper[0], first));
  const Interval along(dot(tangent, middle), dot(abs(tangent), half), load(node.obb_lower[1], first),
                       load(node.obb_upper[1], first));
  const Interval across(dot(third, middle), dot(abs(third), half), load(node.obb_lower[2], first),
                        load(node.obb_upper[2], first));
  const Vec obb_value = hn::Add(hn::Add(up.value, along.value), across.value);
  const auto obb_is_tighter = hn::Gt(obb_value, value);
  const auto along_axis = [&](Vec of_normal, Vec of_tangent, Vec of_third, Vec of_aabb) HWY_ATTR {
    const Vec of_obb = hn::MulAdd(across.out, of_third, hn::MulAdd(along.out, of_tangent, hn::Mul(up.out, of_normal)));
    return hn::IfThenElse(obb_is_tighter, of_obb, of_aabb);
  };
  const Vec3Lanes out{along_axis(normal.x, tangent.x, third.x, x.out), along_axis(normal.y, tangent.y, third.y, y.out),
                      along_axis(normal.z, tangent.z, third.z, z.out)};
  return {less_errors(hn::Max(value, obb_value), out, errors),
          {hn::Add(out.x, out.x), hn::Add(out.y, out.y), hn::Add(out.z, out.z)}};
}

/// From the closest point of a triangle to the query point, in the axes of the BVH.
HWY_INLINE Vec3Lanes displacement_from(const TriangleLanes& triangle, const Arms& arms) {
  const Vec x = hn::Mul(arms.x, hn::CopySign(hn::Set(Lanes(), 1.0F), arms.signed_x));
  const auto along = [&](Vec of_along, Vec of_up, Vec of_across) HWY_ATTR {
    return hn::MulAdd(arms.z, of_across, hn::MulAdd(arms.y, of_up, hn::Mul(x, of_along)));
  };
  return {along(triangle.along.x, triangle.up.x, arms.across.x), along(triangle.along.y, triangle.up.y, arms.across.y),
          along(triangle.along.z, triangle.up.z, arms.across.z)};
}

/// The least that a linear bound, less the upper bound's slope, is in a box.
template <typename D, typename V>
HWY_INLINE V least_in_box(D d, V value, V x, V y, V z, const QueryBox& box) {
  const auto lowered = [&](V from, V slope, std::size_t axis) HWY_ATTR {
    return hn::NegMulAdd(hn::Abs(hn::Sub(slope, hn::Set(d, box.slope[axis]))), hn::Set(d, box.half[axis]), from);
  };
  return lowered(lowered(lowered(value, x, 0), y, 1), z, 2);
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
