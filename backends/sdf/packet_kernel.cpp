#include "backends/sdf/packet_kernel.hpp"

#include <bit>
#include <cmath>
#include <limits>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/sdf/packet_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int stack_capacity = 320;

using Lanes = hn::CappedTag<float, tree_width>;
using Vec = hn::Vec<Lanes>;

struct Vec3Lanes {
  Vec x, y, z;
};

HWY_INLINE Vec load(const TreeLanes& lanes, std::size_t first) { return hn::Load(Lanes(), lanes.data() + first); }

HWY_INLINE Vec3Lanes load(const std::array<TreeLanes, 3>& lanes, std::size_t first) {
  return {load(lanes[0], first), load(lanes[1], first), load(lanes[2], first)};
}

HWY_INLINE Vec3Lanes splat(const std::array<float, 3>& point) {
  const Lanes d;
  return {hn::Set(d, point[0]), hn::Set(d, point[1]), hn::Set(d, point[2])};
}

HWY_INLINE Vec dot(const Vec3Lanes& a, const Vec3Lanes& b) {
  return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}

HWY_INLINE Vec3Lanes cross(const Vec3Lanes& a, const Vec3Lanes& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}

/// From below: value + slope * (place - middle).
struct Bound {
  Vec value;
  Vec3Lanes slope;
};

/// From the middle to the nearest value of an interval, the other way round.
HWY_INLINE Vec beyond(Vec at, Vec lower, Vec upper) { return hn::Sub(at, hn::Min(hn::Max(at, lower), upper)); }

HWY_INLINE Bound bound_of_children(const TreeNode& node, const Vec3Lanes& middle, Vec slack, float reach,
                                   std::size_t first) {
  const Lanes d;
  const Vec3Lanes out{beyond(middle.x, load(node.lower[0], first), load(node.upper[0], first)),
                      beyond(middle.y, load(node.lower[1], first), load(node.upper[1], first)),
                      beyond(middle.z, load(node.lower[2], first), load(node.upper[2], first))};
  const Vec to_box = hn::Sqrt(dot(out, out));
  const Vec inverse = hn::Div(hn::Set(d, 1.0F), hn::Max(to_box, hn::Set(d, 1e-30F)));
  const Vec3Lanes normal = load(node.normal, first);
  const Vec3Lanes tangent = load(node.tangent, first);
  const Vec3Lanes third = cross(normal, tangent);
  const Vec up = beyond(dot(normal, middle), load(node.slab_lower, first), load(node.slab_upper, first));
  const Vec along = beyond(dot(tangent, middle), load(node.side_lower[0], first), load(node.side_upper[0], first));
  const Vec across = beyond(dot(third, middle), load(node.side_lower[1], first), load(node.side_upper[1], first));
  const Vec to_turned = hn::Sqrt(hn::MulAdd(across, across, hn::MulAdd(along, along, hn::Mul(up, up))));
  const Vec inverse_turned = hn::Div(hn::Set(d, 1.0F), hn::Max(to_turned, hn::Set(d, 1e-30F)));
  const auto by_turned = hn::Gt(to_turned, to_box);
  const auto choose = [&](Vec of_normal, Vec of_tangent, Vec of_third, Vec of_box) HWY_ATTR {
    const Vec of_turned = hn::MulAdd(across, of_third, hn::MulAdd(along, of_tangent, hn::Mul(up, of_normal)));
    return hn::IfThenElse(by_turned, hn::Mul(of_turned, inverse_turned), hn::Mul(of_box, inverse));
  };
  // Both boxes are rounded outwards; how far a point is out of one is convex and never more than its distance. The
  // slope is off by the rounding of the ways out over their length, but for the signs of the straight box's.
  const Vec error = hn::Mul(slack, hn::MulAdd(hn::Set(d, 4 * reach), inverse_turned, hn::Set(d, 3.0F)));
  const Vec straight_error = hn::Add(slack, hn::Add(slack, slack));
  return {hn::Sub(hn::Max(to_turned, to_box), hn::IfThenElse(by_turned, error, straight_error)),
          {choose(normal.x, tangent.x, third.x, out.x), choose(normal.y, tangent.y, third.y, out.y),
           choose(normal.z, tangent.z, third.z, out.z)}};
}

/// From the closest point of a triangle to a place, in the triangle's own axes; see triangle_tree_search.cpp, which
/// tells how it errs.
struct Arms {
  Vec x, y, z;
  Vec3Lanes along, up, across;
};

HWY_INLINE Arms arms_to_triangles(const TreeLeaf& leaf, const Vec3Lanes& place, std::size_t first) {
  const Lanes d;
  const Vec zero = hn::Zero(d);
  const Vec3Lanes origin = load(leaf.origin, first);
  const Vec3Lanes arm{hn::Sub(place.x, origin.x), hn::Sub(place.y, origin.y), hn::Sub(place.z, origin.z)};
  const Vec3Lanes along = load(leaf.along, first);
  const Vec3Lanes up = load(leaf.up, first);
  const Vec3Lanes across = cross(along, up);
  const Vec signed_x = dot(arm, along);
  const Vec y = dot(arm, up);
  const Vec width = hn::IfThenElse(hn::Lt(signed_x, zero), load(leaf.before, first), load(leaf.after, first));
  const Vec height = load(leaf.height, first);
  const Vec over = hn::Sub(hn::Abs(signed_x), width);
  const Vec squared_side = hn::MulAdd(width, width, hn::Mul(height, height));
  const Vec run = hn::NegMulAdd(over, width, hn::Mul(y, height));
  const Vec share = hn::Min(hn::Max(hn::Div(run, hn::Max(squared_side, hn::Set(d, 1e-37F))), zero), hn::Set(d, 1.0F));
  const Vec outward = hn::MulAdd(over, height, hn::Mul(y, width));
  const auto at_side = hn::And(hn::Gt(y, zero), hn::Gt(outward, zero));
  const Vec rest_y = hn::IfThenElse(hn::Lt(y, zero), y, hn::Max(hn::Sub(y, height), zero));
  const Vec rest_x = hn::IfThenElse(at_side, hn::MulAdd(share, width, over), hn::Max(over, zero));
  return {hn::Mul(rest_x, hn::CopySign(hn::Set(d, 1.0F), signed_x)),
          hn::IfThenElse(at_side, hn::NegMulAdd(share, height, y), rest_y),
          dot(arm, across),
          along,
          up,
          across};
}

HWY_INLINE Vec squared_length(const Arms& arms) {
  return hn::MulAdd(arms.z, arms.z, hn::MulAdd(arms.x, arms.x, hn::Mul(arms.y, arms.y)));
}

/// A slope that is off by e lowers the bound by no more than e times what the triangle and the packet measure, and e is
/// the rounding of the arms over their length.
HWY_INLINE Bound bound_of_triangles(const TreeLeaf& leaf, const Vec3Lanes& middle, const PacketTask& task,
                                    std::size_t first) {
  const Lanes d;
  const Arms arms = arms_to_triangles(leaf, middle, first);
  const Vec length = hn::Sqrt(squared_length(arms));
  const Vec inverse = hn::Div(hn::Set(d, 1.0F), hn::Max(length, hn::Set(d, 1e-30F)));
  const Vec x = hn::Mul(arms.x, inverse);
  const Vec y = hn::Mul(arms.y, inverse);
  const Vec z = hn::Mul(arms.z, inverse);
  const auto turned = [&](Vec along, Vec up, Vec across)
                          HWY_ATTR { return hn::MulAdd(z, across, hn::MulAdd(y, up, hn::Mul(x, along))); };
  const Vec error = hn::Mul(hn::Set(d, task.slack),
                            hn::MulAdd(hn::Set(d, 4 * (task.longest_side + task.reach)), inverse, hn::Set(d, 3.0F)));
  return {hn::Sub(length, error),
          {turned(arms.along.x, arms.up.x, arms.across.x), turned(arms.along.y, arms.up.y, arms.across.y),
           turned(arms.along.z, arms.up.z, arms.across.z)}};
}

template <typename Mask>
HWY_INLINE unsigned bits_of(Mask mask, std::size_t first) {
  const Lanes d;
  std::uint8_t part[8] = {};
  hn::StoreMaskBits(d, mask, part);
  return (part[0] & ((1U << hn::Lanes(d)) - 1U)) << first;
}

/// Lanes whose bound is within the limit of a point.
HWY_INLINE hn::Mask<Lanes> may_hold_closest(const Bound& bound, const PacketTask::Point& point) {
  const Lanes d;
  return hn::Le(hn::Add(bound.value, dot(bound.slope, splat(point.from_middle))), hn::Set(d, point.limit));
}

void list_triangles(const TreeLeaf& leaf, PacketTask& task, std::size_t n) {
  const Lanes d;
  PacketTask::Point& point = task.points[n];
  alignas(64) float squared[tree_width];
  Vec least = hn::Set(d, std::numeric_limits<float>::max());
  const Vec3Lanes place = splat(point.at);
  for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
    const Vec part = squared_length(arms_to_triangles(leaf, place, first));
    hn::Store(part, d, squared + first);
    least = hn::Min(least, part);
  }
  if (leaf.needles == 0) {
    const float lowered = (std::sqrt(hn::GetLane(hn::MinOfLanes(d, least))) + 2 * task.slack) * 1.000001F;
    point.limit = lowered < point.limit ? lowered : point.limit;
  }
  unsigned found = 0;
  const Vec limit = hn::Set(d, point.limit * point.limit);
  for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
    found |= bits_of(hn::Le(hn::Load(d, squared + first), limit), first);
  }
  for (; found != 0; found &= found - 1) {
    const auto place_in_leaf = static_cast<std::size_t>(std::countr_zero(found));
    point.squared[point.count] = squared[place_in_leaf];
    point.triangle[point.count++] = leaf.triangle[place_in_leaf];
    if (point.count == PacketTask::capacity) {
      task.decide(task, n);
    }
  }
}

HWY_INLINE void look_into_leaf(const TreeLeaf& leaf, const Vec3Lanes& middle, PacketTask& task) {
  const Lanes d;
  unsigned asking = 0;
  for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
    const Bound bound = bound_of_triangles(leaf, middle, task, first);
    for (std::size_t n = 0; n < task.count; ++n) {
      asking |= static_cast<unsigned>(!hn::AllFalse(d, may_hold_closest(bound, task.points[n]))) << n;
    }
  }
  for (; asking != 0; asking &= asking - 1) {
    list_triangles(leaf, task, static_cast<std::size_t>(std::countr_zero(asking)));
  }
}

HWY_INLINE unsigned wanted_children(const TreeNode& node, const Vec3Lanes& middle, const PacketTask& task) {
  const Lanes d;
  unsigned wanted = 0;
  for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
    const Bound bound = bound_of_children(node, middle, hn::Set(d, task.slack), task.reach, first);
    auto any = may_hold_closest(bound, task.points[0]);
    for (std::size_t n = 1; n < task.count; ++n) {
      any = hn::Or(any, may_hold_closest(bound, task.points[n]));
    }
    wanted |= bits_of(any, first);
  }
  return wanted;
}

}  // namespace

void search(PacketTask& task) {
  const Vec3Lanes middle = splat(task.middle);
  for (std::size_t n = 0; n < task.count; ++n) {
    list_triangles(task.leaves[task.first_leaf], task, n);
    if (task.leaves[task.first_leaf].needles != 0) {
      task.decide(task, n);  // the floats gave no limit
    }
  }
  std::array<std::int32_t, stack_capacity> stack;
  int top = 0;
  stack[0] = 0;
  while (top >= 0) {
    const std::int32_t entry = stack[static_cast<std::size_t>(top--)];
    if (entry < 0) {
      if (~entry != task.first_leaf) {
        look_into_leaf(task.leaves[~entry], middle, task);
      }
      continue;
    }
    const TreeNode& node = task.nodes[entry];
    for (unsigned wanted = wanted_children(node, middle, task); wanted != 0; wanted &= wanted - 1) {
      stack[static_cast<std::size_t>(++top)] = node.child[static_cast<std::size_t>(std::countr_zero(wanted))];
    }
  }
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(search);

void search_packet(PacketTask& task) { HWY_DYNAMIC_DISPATCH(search)(task); }

}  // namespace musclebench
#endif
