#include "core/distance/winding_number.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>

#include "core/base/arc_tangent.hpp"

// Highway compiles this file once for every SIMD target; highway.h has to be included after foreach_target.h.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/distance/winding_number.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#include "core/base/vec_lanes-inl.hpp"

#ifndef MUSCLEBENCH_WINDING_LANES
#define MUSCLEBENCH_WINDING_LANES
namespace musclebench {

/// Sums that are kept beside each other, of every eighth triangle, whatever the lanes of the machine.
inline constexpr std::size_t winding_lanes = 8;

using WindingLanes = std::array<double, winding_lanes>;

/// Of triangles, x, y and z of the corners a, b and c as seen from the point.
struct alignas(64) CornerLanes {
  std::array<WindingLanes, 9> of = {};
};

/// The products of SolidAngleSum.
struct alignas(64) AngleLanes {
  WindingLanes real = {1, 1, 1, 1, 1, 1, 1, 1};
  WindingLanes imaginary = {};
  WindingLanes turns = {};
};

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<double, winding_lanes>;
using Lane = hn::Vec<Lanes>;
using VecLanes = VecLanesOf<Lane>;

HWY_INLINE VecLanes corner(const CornerLanes& corners, std::size_t coordinate, std::size_t first) {
  const Lanes d;
  return {hn::Load(d, corners.of[coordinate].data() + first), hn::Load(d, corners.of[coordinate + 1].data() + first),
          hn::Load(d, corners.of[coordinate + 2].data() + first)};
}

/// Line by line SolidAngleSum::add.
HWY_INLINE void add_lanes(const CornerLanes& corners, std::size_t first, AngleLanes& angles) {
  const Lanes d;
  const Lane zero = hn::Zero(d);
  const VecLanes a = corner(corners, 0, first);
  const VecLanes b = corner(corners, 3, first);
  const VecLanes c = corner(corners, 6, first);
  const Lane la = hn::Sqrt(dot(a, a));
  const Lane lb = hn::Sqrt(dot(b, b));
  const Lane lc = hn::Sqrt(dot(c, c));
  const Lane opposite = dot(a, cross(b, c));
  const Lane adjacent =
      hn::Add(hn::Add(hn::Add(hn::Mul(hn::Mul(la, lb), lc), hn::Mul(dot(a, b), lc)), hn::Mul(dot(b, c), la)),
              hn::Mul(dot(c, a), lb));
  const Lane old_real = hn::Load(d, angles.real.data() + first);
  const Lane old_imaginary = hn::Load(d, angles.imaginary.data() + first);
  const Lane real = hn::Sub(hn::Mul(old_real, adjacent), hn::Mul(old_imaginary, opposite));
  const Lane imaginary = hn::Add(hn::Mul(old_imaginary, adjacent), hn::Mul(old_real, opposite));
  const auto was_below = hn::Lt(old_imaginary, zero);
  const auto is_below = hn::Lt(imaginary, zero);
  const auto onwards = hn::And(hn::AndNot(was_below, is_below), hn::Gt(opposite, zero));
  const auto is_beyond = hn::Or(hn::Gt(imaginary, zero), hn::Lt(real, zero));
  const auto back = hn::And(hn::And(hn::AndNot(is_below, was_below), hn::Lt(opposite, zero)), is_beyond);
  const Lane one = hn::Set(d, 1);
  const Lane turns = hn::Add(hn::Load(d, angles.turns.data() + first), hn::IfThenElseZero(onwards, one));
  hn::Store(hn::Sub(turns, hn::IfThenElseZero(back, one)), d, angles.turns.data() + first);
  const Lane size = hn::Max(hn::Abs(real), hn::Abs(imaginary));
  // Infinite: the products of lengths above 1e102 m, which no two kinds of SIMD treat alike.
  const auto is_finite = hn::And(hn::IsFinite(real), hn::IsFinite(imaginary));
  const auto counts = hn::And(hn::And(hn::Ne(opposite, zero), hn::Gt(size, zero)), is_finite);
  hn::Store(hn::IfThenElse(counts, hn::Div(real, size), old_real), d, angles.real.data() + first);
  hn::Store(hn::IfThenElse(counts, hn::Div(imaginary, size), old_imaginary), d, angles.imaginary.data() + first);
}

void add_all(std::span<const Triangle> triangles, const Vec3* vertices, const Vec3& point, AngleLanes& angles) {
  CornerLanes corners;
  for (std::size_t start = 0; start < triangles.size(); start += winding_lanes) {
    const std::size_t count = std::min(winding_lanes, triangles.size() - start);
    if (count < winding_lanes) corners = {};  // of a triangle without area
    for (std::size_t lane = 0; lane < count; ++lane) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3& vertex = vertices[triangles[start + lane][i]];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto at = static_cast<Eigen::Index>(axis);
          corners.of[3 * i + axis][lane] = vertex[at] - point[at];
        }
      }
    }
    for (std::size_t first = 0; first < winding_lanes; first += hn::Lanes(Lanes())) add_lanes(corners, first, angles);
  }
}

}  // namespace
}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(add_all);

double winding_number(std::span<const Triangle> triangles, std::span<const Vec3> vertices, const Vec3& point) {
  AngleLanes angles;
  HWY_DYNAMIC_DISPATCH(add_all)(triangles, vertices.data(), point, angles);
  double winding = 0;
  for (std::size_t lane = 0; lane < winding_lanes; ++lane) {
    winding += angles.turns[lane] + arc_tangent2(angles.imaginary[lane], angles.real[lane]) / (2 * std::numbers::pi);
  }
  return winding;
}

}  // namespace musclebench
#endif
