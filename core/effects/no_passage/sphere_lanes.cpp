#include "core/effects/no_passage/sphere_lanes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/effects/no_passage/sphere_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/bvh/triangle_bvh_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

/// The same of one sphere in all lanes.
HWY_INLINE Vec3Lanes splat_lane(const std::array<BvhLanes, 3>& lanes, std::size_t lane) {
  return splat({lanes[0][lane], lanes[1][lane], lanes[2][lane]});
}

HWY_INLINE Vec3Lanes difference(const Vec3Lanes& one, const Vec3Lanes& other) {
  return {hn::Sub(one.x, other.x), hn::Sub(one.y, other.y), hn::Sub(one.z, other.z)};
}

std::uint64_t used_up(const SphereLanes& first, const SphereLanes& second, float least_m, float soon_m,
                      PairDistances& left_m) {
  const Lanes d;
  const Vec shrink = hn::Set(d, 1 - lane_rounding);
  const Vec grow = hn::Set(d, 1 + lane_rounding);
  const Vec least = hn::Set(d, least_m);
  std::uint64_t found = 0;
  for (std::size_t from = 0; from < bvh_width; from += hn::Lanes(d)) {
    const Vec3Lanes centres = load(second.from, from);
    const Vec3Lanes moves = load(second.move, from);
    const Vec radii = load(second.radius_m, from);
    const Vec spreads = load(second.spread_m, from);
    for (std::size_t i = 0; i < bvh_width; ++i) {
      const Vec radius = hn::Add(radii, hn::Set(d, first.radius_m[i]));
      const Vec3Lanes from_second = difference(splat_lane(first.from, i), centres);
      const Vec squared_apart = dot(from_second, from_second);
      const Vec apart = hn::Sub(hn::Mul(shrink, hn::Sqrt(squared_apart)), radius);
      const Vec left = hn::Max(load(left_m[i], from), apart);
      hn::Store(left, d, left_m[i].data() + from);
      const Vec spread = hn::Add(spreads, hn::Set(d, first.spread_m[i]));
      const Vec3Lanes move = difference(splat_lane(first.move, i), moves);
      const Vec squared_move = dot(move, move);
      const Vec approach = hn::Mul(grow, hn::Add(hn::Sqrt(squared_move), spread));
      const auto is_used_up = hn::Not(hn::Gt(left, hn::Add(approach, least)));
      // Where the centres are closest on their paths.
      const Vec towards = hn::Min(hn::Max(hn::Neg(dot(from_second, move)), hn::Zero(d)), squared_move);
      const Vec when = hn::IfThenElseZero(hn::Gt(squared_move, hn::Zero(d)), hn::Div(towards, squared_move));
      const Vec3Lanes then{hn::MulAdd(when, move.x, from_second.x), hn::MulAdd(when, move.y, from_second.y),
                           hn::MulAdd(when, move.z, from_second.z)};
      const Vec closest = hn::Sub(hn::Sub(hn::Mul(shrink, hn::Sqrt(dot(then, then))), radius), spread);
      const auto may_meet = hn::AndNot(hn::Gt(closest, least), is_used_up);
      const auto is_soon = hn::Not(hn::Gt(left, hn::Set(d, soon_m)));
      found |= static_cast<std::uint64_t>(bits_of(d, hn::Or(may_meet, is_soon), from)) << (bvh_width * i);
    }
  }
  return found;
}

float take_off(const SphereLanes& first, const SphereLanes& second, PairDistances& left_m) {
  const Lanes d;
  const Vec grow = hn::Set(d, 1 + lane_rounding);
  Vec least = hn::Set(d, nowhere_m);
  for (std::size_t from = 0; from < bvh_width; from += hn::Lanes(d)) {
    const Vec3Lanes moves = load(second.move, from);
    const Vec spreads = load(second.spread_m, from);
    for (std::size_t i = 0; i < bvh_width; ++i) {
      const Vec spread = hn::Add(spreads, hn::Set(d, first.spread_m[i]));
      const Vec3Lanes move = difference(splat_lane(first.move, i), moves);
      const Vec approach = hn::Mul(grow, hn::Add(hn::Sqrt(dot(move, move)), spread));
      const Vec before = load(left_m[i], from);
      const Vec left = hn::Sub(before, hn::MulAdd(hn::Set(d, 0x1p-23F), hn::Abs(before), approach));
      hn::Store(left, d, left_m[i].data() + from);
      least = hn::Min(least, left);
    }
  }
  return hn::GetLane(hn::MinOfLanes(d, least));
}

}  // namespace
}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(used_up);
HWY_EXPORT(take_off);

std::uint64_t used_up_slots(const SphereLanes& first, const SphereLanes& second, float least_m, float soon_m,
                            PairDistances& left_m) {
  return HWY_DYNAMIC_DISPATCH(used_up)(first, second, least_m, soon_m, left_m);
}

float take_off_approach(const SphereLanes& first, const SphereLanes& second, PairDistances& left_m) {
  return HWY_DYNAMIC_DISPATCH(take_off)(first, second, left_m);
}

}  // namespace musclebench
#endif
