#include "core/distance/closest_on_triangles.hpp"

#include <algorithm>

#include "core/base/prefetch.hpp"

// Highway compiles this file once for every SIMD target; highway.h has to be included after foreach_target.h.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/distance/closest_on_triangles.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#include "core/base/vec_lanes-inl.hpp"

// Line by line closest_on_triangle with its products and sums in the same order and none of them fused, so that the
// results have the same bits.
HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<double, ClosestOnTriangles::width>;
using IntLanes = hn::RebindToSigned<Lanes>;
using Vec = hn::Vec<Lanes>;
using IntVec = hn::Vec<IntLanes>;
using Mask = hn::Mask<Lanes>;
using Vec3Lanes = VecLanesOf<Vec>;

HWY_INLINE Vec3Lanes choose(Mask mask, const Vec3Lanes& yes, const Vec3Lanes& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y), hn::IfThenElse(mask, yes.z, no.z)};
}

HWY_INLINE Vec3Lanes gather(const double* first, IntVec index) {
  const Lanes d;
  return {hn::GatherIndex(d, first, index), hn::GatherIndex(d, first + 1, index), hn::GatherIndex(d, first + 2, index)};
}

HWY_INLINE IntVec widened(const std::int32_t* numbers) {
  const IntLanes di;
  return hn::PromoteTo(di, hn::LoadU(hn::Rebind<std::int32_t, IntLanes>(), numbers));
}

HWY_INLINE IntVec feature(Feature which) { return hn::Set(IntLanes(), static_cast<std::int64_t>(which)); }

struct Closest {
  Vec squared;
  Vec3Lanes point;
  IntVec feature;
};

HWY_INLINE void take_where(Mask mask, const Closest& other, Closest& best) {
  best.squared = hn::IfThenElse(mask, other.squared, best.squared);
  best.point = choose(mask, other.point, best.point);
  best.feature = hn::IfThenElse(hn::RebindMask(IntLanes(), mask), other.feature, best.feature);
}

HWY_INLINE Closest on_edge(const Vec3Lanes& point, const Vec3Lanes& from, const Vec3Lanes& to,
                           const Vec3Lanes& direction, int edge) {
  const auto number = [](int of) { return static_cast<Feature>(of); };
  const Vec along = dot(direction, point - from);
  const Vec squared_length = dot(direction, direction);
  Closest result;
  result.point = from + hn::Div(along, squared_length) * direction;
  result.feature = feature(number(static_cast<int>(Feature::edge_0) + edge));
  const Mask before = hn::Le(along, hn::Zero(Lanes()));
  const Mask beyond = hn::AndNot(before, hn::Ge(along, squared_length));
  result.point = choose(before, from, choose(beyond, to, result.point));
  const int corner = static_cast<int>(Feature::corner_0);
  const IntVec corner_of_from = feature(number(corner + edge));
  const IntVec corner_of_to = feature(number(corner + (edge + 1) % 3));
  result.feature = hn::IfThenElse(hn::RebindMask(IntLanes(), before), corner_of_from,
                                  hn::IfThenElse(hn::RebindMask(IntLanes(), beyond), corner_of_to, result.feature));
  const Vec3Lanes displacement = point - result.point;
  result.squared = dot(displacement, displacement);
  return result;
}

/// See has_area in triangle_distance.hpp.
HWY_INLINE Mask has_area(Vec squared_normal, const Vec3Lanes& ab, const Vec3Lanes& ac) {
  const Lanes d;
  const Vec squared_ab = dot(ab, ab);
  const Vec squared_ac = dot(ac, ac);
  const Vec product = hn::Mul(squared_ab, squared_ac);
  // Square roots are needed only close to the threshold.
  if (hn::AllTrue(d, hn::And(hn::Gt(squared_normal, hn::Mul(hn::Set(d, 10 * flat_sine * flat_sine), product)),
                             hn::Gt(product, hn::Set(d, 1e-200))))) {
    return hn::Eq(product, product);
  }
  const Vec flat = hn::Mul(hn::Mul(hn::Set(d, flat_sine), hn::Sqrt(squared_ab)), hn::Sqrt(squared_ac));
  return hn::Gt(squared_normal, hn::Mul(flat, flat));
}

HWY_INLINE Closest closest(const Vec3Lanes& point, const Vec3Lanes& a, const Vec3Lanes& b, const Vec3Lanes& c) {
  const Lanes d;
  const Vec zero = hn::Zero(d);
  const Vec3Lanes ab = b - a;
  const Vec3Lanes ac = c - a;
  const Vec3Lanes ap = point - a;
  const Vec3Lanes normal = cross(ab, ac);
  const Vec squared_normal = dot(normal, normal);
  const Vec v = hn::Div(dot(normal, cross(ap, ac)), squared_normal);
  const Vec w = hn::Div(dot(normal, cross(ab, ap)), squared_normal);
  const Mask within = hn::And(hn::And(hn::Ge(v, zero), hn::Ge(w, zero)), hn::Le(hn::Add(v, w), hn::Set(d, 1.0)));
  const Mask on_face = hn::And(has_area(squared_normal, ab, ac), within);
  Closest face;
  face.point = (a + v * ab) + w * ac;
  face.feature = feature(Feature::face);
  const Vec3Lanes displacement = point - face.point;
  face.squared = dot(displacement, displacement);
  if (hn::AllTrue(d, on_face)) {
    return face;
  }
  Closest best = on_edge(point, a, b, ab, 0);
  for (const int edge : {1, 2}) {
    const Closest other = edge == 1 ? on_edge(point, b, c, c - b, 1) : on_edge(point, c, a, a - c, 2);
    take_where(hn::Lt(other.squared, best.squared), other, best);
  }
  take_where(on_face, face, best);
  return best;
}

/// Pairs whose corners are prefetched ahead of their turn.
constexpr std::size_t prefetch_distance = 2 * ClosestOnTriangles::width;

HWY_INLINE void prefetch_corners(const std::array<Vec3, 3>* corners, std::span<const std::int32_t> triangles) {
  for (const std::int32_t triangle : triangles) {
    prefetch(corners[triangle]);
  }
}

void all(const Vec3* points, const std::array<Vec3, 3>* corners, std::span<const std::int32_t> point,
         std::span<const std::int32_t> triangle, std::span<ClosestOnTriangles> found) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(corners[0]) == 9 * sizeof(double));
  const Lanes d;
  const IntLanes di;
  const auto thrice = [](IntVec v) HWY_ATTR { return hn::Add(hn::Add(v, v), v); };
  const double* first_corner = corners->data()->data();
  for (std::size_t start = 0; start < point.size(); start += ClosestOnTriangles::width) {
    ClosestOnTriangles& eight = found[start / ClosestOnTriangles::width];
    const std::size_t later = std::min(start + prefetch_distance, triangle.size());
    prefetch_corners(corners, triangle.subspan(later, std::min(ClosestOnTriangles::width, triangle.size() - later)));
    for (std::size_t first = 0; first < ClosestOnTriangles::width; first += hn::Lanes(d)) {
      const Vec3Lanes query = gather(points->data(), thrice(widened(point.data() + start + first)));
      const IntVec first_coordinate = thrice(thrice(widened(triangle.data() + start + first)));
      const Closest best =
          closest(query, gather(first_corner, first_coordinate), gather(first_corner + 3, first_coordinate),
                  gather(first_corner + 6, first_coordinate));
      hn::Store(best.squared, d, eight.squared_distance_m2.data() + first);
      hn::Store(best.point.x, d, eight.x.data() + first);
      hn::Store(best.point.y, d, eight.y.data() + first);
      hn::Store(best.point.z, d, eight.z.data() + first);
      hn::Store(best.feature, di, eight.feature.data() + first);
    }
  }
}

}  // namespace
}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(all);

void closest_on_triangles(const Vec3* points, const std::array<Vec3, 3>* corners, std::span<const std::int32_t> point,
                          std::span<const std::int32_t> triangle, std::span<ClosestOnTriangles> found) {
  HWY_DYNAMIC_DISPATCH(all)(points, corners, point, triangle, found);
}

}  // namespace musclebench
#endif
