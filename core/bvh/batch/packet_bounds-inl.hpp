// Linear bounds of squared distances, for all places of a box at once. Included by each file that is compiled once for
// every kind of SIMD, after highway.h.
#if defined(MUSCLEBENCH_PACKET_BOUNDS) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_PACKET_BOUNDS
#undef MUSCLEBENCH_PACKET_BOUNDS
#else
#define MUSCLEBENCH_PACKET_BOUNDS
#endif

#include <cmath>
#include <cstddef>

#include <hwy/highway.h>

#include "core/bvh/batch/packet_lists.hpp"
#include "core/bvh/triangle_bvh_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro

// The squared distance to any set of places, less |place|^2, is the least of linear functions and so concave. With r =
// place - middle and the set's closest place q to the middle, w = middle - q:
//
//   w^2 + 2 w r - k <= squared distance - r^2 <= w^2 + 2 w r,  k = e (2 R - e), e = min(R, E),
//
// where R is the longest r and E the longest way from q to a place of a convex set. So two sets that are small against
// the way between their bisector and the middle are told apart nearly as well by these linear functions as by their
// distances, over a box as large as one likes. A box is the sum of its axes, each of which has its own E and R, which
// is less by w: beyond that, q stays the closest.
//
// Rounding: the slack bounds how far a float distance is off (triangle_bvh_search.cpp); w and q are within 4 of it,
// and of k only what is within the box counts.

/// From below: squared distance - r^2 >= value + slope * r.
struct Bound {
  Vec value;
  Vec3Lanes slope;
};

/// How far the bounds of a box may be off: `share` times the sum of the coordinates of w, and `fixed` more.
struct Errors {
  float share;
  float fixed;
  float reach;  ///< of the box from its middle

  Errors(const TreeView& tree, const PlaceBox& box)
      : share(8 * tree.slack),
        fixed(0),
        reach(1.000001F *
              std::sqrt(box.half[0] * box.half[0] + box.half[1] * box.half[1] + box.half[2] * box.half[2])) {
    // The axes of turned boxes are a little short.
    fixed = tree.slack * (10 * (reach + tree.longest_side) + 20 * tree.slack) + 5e-6F * reach * reach;
  }
};

HWY_INLINE Vec sum_of_sizes(const Vec3Lanes& a) { return hn::Add(hn::Add(hn::Abs(a.x), hn::Abs(a.y)), hn::Abs(a.z)); }

HWY_INLINE Vec less_errors(Vec value, const Vec3Lanes& way, const Errors& errors) {
  const Lanes d;
  return hn::Sub(hn::NegMulAdd(hn::Set(d, errors.share), sum_of_sizes(way), value), hn::Set(d, errors.fixed));
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
                                   const Errors& errors, std::size_t first) {
  const Interval x(middle.x, half.x, load(node.lower[0], first), load(node.upper[0], first));
  const Interval y(middle.y, half.y, load(node.lower[1], first), load(node.upper[1], first));
  const Interval z(middle.z, half.z, load(node.lower[2], first), load(node.upper[2], first));
  const Vec value = hn::Add(hn::Add(x.value, y.value), z.value);
  const Vec3Lanes normal = load(node.normal, first);
  const Vec3Lanes tangent = load(node.tangent, first);
  const Vec3Lanes third = cross(normal, tangent);
  const Interval up(dot(normal, middle), dot(abs(normal), half), load(node.slab_lower, first),
                    load(node.slab_upper, first));
  const Interval along(dot(tangent, middle), dot(abs(tangent), half), load(node.side_lower[0], first),
                       load(node.side_upper[0], first));
  const Interval across(dot(third, middle), dot(abs(third), half), load(node.side_lower[1], first),
                        load(node.side_upper[1], first));
  const Vec turned_value = hn::Add(hn::Add(up.value, along.value), across.value);
  const auto by_turned = hn::Gt(turned_value, value);
  const auto way = [&](Vec of_normal, Vec of_tangent, Vec of_third, Vec of_box) HWY_ATTR {
    const Vec of_turned =
        hn::MulAdd(across.out, of_third, hn::MulAdd(along.out, of_tangent, hn::Mul(up.out, of_normal)));
    return hn::IfThenElse(by_turned, of_turned, of_box);
  };
  const Vec3Lanes out{way(normal.x, tangent.x, third.x, x.out), way(normal.y, tangent.y, third.y, y.out),
                      way(normal.z, tangent.z, third.z, z.out)};
  return {less_errors(hn::Max(value, turned_value), out, errors),
          {hn::Add(out.x, out.x), hn::Add(out.y, out.y), hn::Add(out.z, out.z)}};
}

/// From the closest point of a triangle in the axes of the tree.
HWY_INLINE Vec3Lanes way_of(const TriangleLanes& triangle, const Arms& arms) {
  const Vec x = hn::Mul(arms.x, hn::CopySign(hn::Set(Lanes(), 1.0F), arms.signed_x));
  const auto along = [&](Vec of_along, Vec of_up, Vec of_across) HWY_ATTR {
    return hn::MulAdd(arms.z, of_across, hn::MulAdd(arms.y, of_up, hn::Mul(x, of_along)));
  };
  return {along(triangle.along.x, triangle.up.x, arms.across.x), along(triangle.along.y, triangle.up.y, arms.across.y),
          along(triangle.along.z, triangle.up.z, arms.across.z)};
}

/// The least that a linear bound, less the upper bound's slope, is in a box.
template <typename D, typename V>
HWY_INLINE V least_in_box(D d, V value, V x, V y, V z, const PlaceBox& box) {
  const auto lowered = [&](V from, V slope, std::size_t axis) HWY_ATTR {
    return hn::NegMulAdd(hn::Abs(hn::Sub(slope, hn::Set(d, box.slope[axis]))), hn::Set(d, box.half[axis]), from);
  };
  return lowered(lowered(lowered(value, x, 0), y, 1), z, 2);
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
