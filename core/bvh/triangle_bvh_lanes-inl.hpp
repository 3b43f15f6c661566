// SIMD distances from points to the triangles of a BVH leaf. Each source file that Highway compiles for several targets
// includes this after highway.h, so that there is one copy a target.
#if defined(MUSCLEBENCH_TRIANGLE_BVH_LANES) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_TRIANGLE_BVH_LANES
#undef MUSCLEBENCH_TRIANGLE_BVH_LANES
#else
#define MUSCLEBENCH_TRIANGLE_BVH_LANES
#endif

#include <array>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "core/bvh/triangle_bvh_nodes.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, bvh_width>;
using IntLanes = hn::RebindToSigned<Lanes>;
using Vec = hn::Vec<Lanes>;

/// One vector a lane, as a structure of arrays.
template <typename V>
struct Vec3Of {
  V x, y, z;
};
using Vec3Lanes = Vec3Of<Vec>;

HWY_INLINE Vec load(const BvhLanes& lanes, std::size_t first) { return hn::Load(Lanes(), lanes.data() + first); }

HWY_INLINE Vec3Lanes load(const std::array<BvhLanes, 3>& lanes, std::size_t first) {
  return {load(lanes[0], first), load(lanes[1], first), load(lanes[2], first)};
}

HWY_INLINE Vec3Lanes splat(const std::array<float, 3>& vector) {
  const Lanes d;
  return {hn::Set(d, vector[0]), hn::Set(d, vector[1]), hn::Set(d, vector[2])};
}

template <typename V>
HWY_INLINE V dot(const Vec3Of<V>& a, const Vec3Of<V>& b) {
  return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}

template <typename V>
HWY_INLINE Vec3Of<V> cross(const Vec3Of<V>& a, const Vec3Of<V>& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}

/// Triangles of a leaf in their own axes, one a lane; or one of them in all lanes.
struct TriangleLanes {
  Vec3Lanes origin, along, up;
  Vec before, after, height;

  static HWY_INLINE TriangleLanes of(const BvhLeaf& leaf, std::size_t first) {
    return {load(leaf.origin, first), load(leaf.along, first), load(leaf.up, first),
            load(leaf.before, first), load(leaf.after, first), load(leaf.height, first)};
  }
  static HWY_INLINE TriangleLanes one(const BvhLeaf& leaf, std::size_t lane) {
    const Lanes d;
    const auto all = [&](const std::array<BvhLanes, 3>& lanes) HWY_ATTR {
      return splat({lanes[0][lane], lanes[1][lane], lanes[2][lane]});
    };
    return {all(leaf.origin),
            all(leaf.along),
            all(leaf.up),
            hn::Set(d, leaf.before[lane]),
            hn::Set(d, leaf.after[lane]),
            hn::Set(d, leaf.height[lane])};
  }
};

/// Difference between a point and its closest point on a triangle, in the triangle's own axes.
struct Arms {
  Vec x;  ///< mirrored to positive `signed_x`
  Vec y, z;
  Vec signed_x;      ///< of the point, along the longest side from the foot of the height
  Vec3Lanes across;  ///< the third axis

  [[nodiscard]] HWY_INLINE Vec squared_length() const { return hn::MulAdd(z, z, hn::MulAdd(x, x, hn::Mul(y, y))); }
};

/// By the half of the triangle on the point's side of its height, a right triangle; the cases are derived in
/// reports/performance/bvh_error_bounds.md.
HWY_INLINE Arms arms_to(const TriangleLanes& triangle, const Vec3Lanes& point) {
  const Lanes d;
  const Vec zero = hn::Zero(d);
  const Vec3Lanes arm{hn::Sub(point.x, triangle.origin.x), hn::Sub(point.y, triangle.origin.y),
                      hn::Sub(point.z, triangle.origin.z)};
  const Vec3Lanes across = cross(triangle.along, triangle.up);
  const Vec signed_x = dot(arm, triangle.along);
  const Vec y = dot(arm, triangle.up);
  const auto is_before = hn::Lt(signed_x, zero);
  const Vec width = hn::IfThenElse(is_before, triangle.before, triangle.after);
  const Vec height = triangle.height;
  const Vec over = hn::Sub(hn::Abs(signed_x), width);
  const Vec run = hn::NegMulAdd(over, width, hn::Mul(y, height));
  // Positive for a degenerate triangle, too.
  const Vec squared_side = hn::Max(hn::MulAdd(width, width, hn::Mul(height, height)), hn::Set(d, 1e-37F));
  const Vec fraction = hn::Min(hn::Max(hn::Div(run, squared_side), zero), hn::Set(d, 1.0F));
  const Vec outward = hn::MulAdd(over, height, hn::Mul(y, width));
  const auto by_slanted_side = hn::Gt(outward, zero);
  const Vec rest_y = hn::Max(hn::Sub(y, height), hn::Min(y, zero));
  return {hn::IfThenElse(by_slanted_side, hn::MulAdd(fraction, width, over), hn::Max(over, zero)),
          hn::IfThenElse(by_slanted_side, hn::NegMulAdd(fraction, height, y), rest_y), dot(arm, across), signed_x,
          across};
}

/// One bit a lane of a mask; lane 0 is bit `first`.
template <typename D, typename Mask>
HWY_INLINE unsigned bits_of(D d, Mask mask, std::size_t first) {
  std::uint8_t part[8] = {};
  hn::StoreMaskBits(d, mask, part);
  const unsigned all = part[0] | static_cast<unsigned>(part[1]) << 8U;
  return (all & ((1U << hn::Lanes(d)) - 1U)) << first;
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
