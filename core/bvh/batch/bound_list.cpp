#include "core/bvh/batch/bound_list.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/prefetch.hpp"

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/bvh/batch/bound_list.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "core/bvh/batch/list_scan-inl.hpp"
#include "core/bvh/batch/linear_bounds-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

HWY_INLINE void append(const Bound& bound, hn::Mask<Lanes> mask, hn::Vec<IntLanes> child, BoundList& list) {
  const Lanes d;
  const IntLanes di;
  hn::StoreU(hn::Compress(bound.value, mask), d, list.value.data() + list.count);
  hn::StoreU(hn::Compress(bound.slope.x, mask), d, list.slope[0].data() + list.count);
  hn::StoreU(hn::Compress(bound.slope.y, mask), d, list.slope[1].data() + list.count);
  hn::StoreU(hn::Compress(bound.slope.z, mask), d, list.slope[2].data() + list.count);
  hn::StoreU(hn::Compress(child, hn::RebindMask(di, mask)), di, list.child.data() + list.count);
  list.count += hn::CountTrue(d, mask);
}

HWY_INLINE void close(BoundList& list) {
  const Wide w;
  list.make_room(0);
  for (std::size_t first = 0; first < BoundList::padding; first += hn::Lanes(w)) {
    hn::StoreU(hn::Set(w, far_away), w, list.value.data() + list.count + first);
    for (std::vector<float>& slope : list.slope) {
      hn::StoreU(hn::Zero(w), w, slope.data() + list.count + first);
    }
  }
}

std::array<float, 3> displacement(const std::array<float, 3>& from, const std::array<float, 3>& to) {
  return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

HWY_INLINE TriangleLanes triangle_of(const BvhView& bvh, std::int32_t number) {
  return TriangleLanes::one(bvh.leaves[static_cast<std::size_t>(number) / bvh_width],
                            static_cast<std::size_t>(number) % bvh_width);
}

HWY_INLINE float squared_length(const std::array<float, 3>& offset) {
  return offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
}

/// Lowers the upper bound by the point of one triangle that is the closest to the middle.
HWY_INLINE void lower_bound_by(const BvhView& bvh, std::int32_t number, QueryBox& box) {
  const TriangleLanes triangle = triangle_of(bvh, number);
  const Arms arms = arms_to(triangle, splat(box.middle));
  const Vec3Lanes offset = displacement_from(triangle, arms);
  const float sizes = hn::GetLane(sum_of_sizes(offset)) + BoundErrors(bvh, box).reach;
  // The distance to the closest triangle may be rounded up, and so may what is computed with this bound.
  const float most = hn::GetLane(arms.squared_length()) + bvh.slack * (16 * sizes + 64 * bvh.slack);
  if (most < box.most) {
    box.most = most;
    box.slope = {2 * hn::GetLane(offset.x), 2 * hn::GetLane(offset.y), 2 * hn::GetLane(offset.z)};
  }
}

/// The same by the triangle of a leaf that is the nearest to the middle.
HWY_INLINE void lower_bound_by_nearest(const BvhView& bvh, std::int32_t index, QueryBox& box) {
  const Lanes d;
  const BvhLeaf& leaf = bvh.leaves[index];
  alignas(64) BvhLanes squared;
  Vec least = hn::Set(d, far_away);
  for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
    const Vec part = arms_to(TriangleLanes::of(leaf, first), splat(box.middle)).squared_length();
    hn::Store(part, d, squared.data() + first);
    least = hn::Min(least, part);
  }
  const Vec limit = hn::MinOfLanes(d, least);
  unsigned nearest = 0;
  for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
    nearest |= bits_of(d, hn::Le(load(squared, first), limit), first);
  }
  nearest &= ~leaf.slivers;
  if (nearest != 0) {
    lower_bound_by(bvh, index * static_cast<std::int32_t>(bvh_width) + std::countr_zero(nearest), box);
  }
}

/// The upper bound of a box, moved to another middle that is `offset` from its own.
void bound_as(const QueryBox& box, const std::array<float, 3>& offset, const BvhView& bvh, QueryBox& part) {
  float sizes = 0;
  part.most = box.most + squared_length(offset);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    part.slope[axis] = box.slope[axis] + 2 * offset[axis];
    part.most += box.slope[axis] * offset[axis];
    sizes += std::abs(box.slope[axis]) + std::abs(offset[axis]);
  }
  part.most += bvh.slack * (sizes + bvh.slack);
}

/// Keeps the entries of a list that may be near a box whose middle is `offset` from the list's; moves their bounds
/// there.
HWY_INLINE void keep_near(const BoundList& list, const std::array<float, 3>& offset, const QueryBox& box,
                          BoundList& near) {
  const Wide w;
  const hn::RebindToSigned<Wide> wi;
  const WideVec squared_offset = hn::Set(w, squared_length(offset));
  near.count = 0;
  near.make_room(list.count);
  for (std::size_t start = 0; start < list.count; start += hn::Lanes(w)) {
    const WideVec value = hn::Add(hn::LoadU(w, list.value.data() + start), squared_offset);
    const WideVec bounds = bounds_at(list, start, value, offset);
    const auto slope = [&](std::size_t axis) HWY_ATTR {
      return hn::Add(hn::LoadU(w, list.slope[axis].data() + start), hn::Set(w, 2 * offset[axis]));
    };
    const auto kept = hn::Le(least_in_box(w, bounds, slope(0), slope(1), slope(2), box), hn::Set(w, box.most));
    if (hn::AllFalse(w, kept)) {
      continue;
    }
    hn::StoreU(hn::Compress(bounds, kept), w, near.value.data() + near.count);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      hn::StoreU(hn::Compress(slope(axis), kept), w, near.slope[axis].data() + near.count);
    }
    hn::StoreU(hn::Compress(hn::LoadU(wi, list.child.data() + start), hn::RebindMask(wi, kept)), wi,
               near.child.data() + near.count);
    near.count += hn::CountTrue(w, kept);
  }
  close(near);
}

}  // namespace

void by_triangle(const BvhView& bvh, std::int32_t triangle, QueryBox& box) { lower_bound_by(bvh, triangle, box); }

void nodes_of(const BvhView& bvh, const QueryBox& box, BoundList& nodes) {
  const Lanes d;
  const IntLanes di;
  const BoundErrors errors(bvh, box);
  const Vec3Lanes middle = splat(box.middle);
  const Vec3Lanes half = splat(box.half);
  const Vec most = hn::Set(d, box.most);
  // Nodes without a leaf below them stay in the list, but far away.
  BoundList& waiting = nodes;
  waiting.count = 0;
  waiting.make_room(bvh_width);
  waiting.value[0] = -far_away;
  waiting.child[0] = 0;
  for (std::vector<float>& slope : waiting.slope) {
    slope[0] = 0;
  }
  waiting.count = 1;
  for (std::size_t next = 0; next < waiting.count; ++next) {
    const BvhNode& node = bvh.nodes[waiting.child[next]];
    bool has_leaf = false;
    waiting.make_room(bvh_width);
    prefetch(bvh.nodes[waiting.child[std::min(next + 2, waiting.count - 1)]]);
    for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
      const Bound bound = bound_of_children(node, middle, half, errors, first);
      const auto wanted = hn::Le(least_in_box(d, bound.value, bound.slope.x, bound.slope.y, bound.slope.z, box), most);
      const auto child = hn::Load(di, node.child.data() + first);
      const auto inner = hn::AndNot(hn::Lt(child, hn::Zero(di)), hn::RebindMask(di, wanted));
      append(bound, hn::RebindMask(d, inner), child, waiting);
      has_leaf = has_leaf || !hn::AllTrue(di, hn::Or(inner, hn::RebindMask(di, hn::Not(wanted))));
    }
    if (!has_leaf) {
      waiting.value[next] = far_away;
    }
  }
  close(nodes);
}

namespace {

/// The leaf below a node that is the nearest to the middle of the box; -1: none.
HWY_INLINE std::int32_t nearest_leaf(const BvhNode& node, const Vec3Lanes& middle, const Vec3Lanes& half,
                                     const BoundErrors& errors) {
  const Lanes d;
  alignas(64) BvhLanes value;
  for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
    hn::Store(bound_of_children(node, middle, half, errors, first).value, d, value.data() + first);
  }
  std::int32_t nearest = -1;
  float least = far_away;
  for (std::size_t lane = 0; lane < bvh_width; ++lane) {
    if (node.child[lane] < 0 && value[lane] < least) {
      least = value[lane];
      nearest = ~node.child[lane];
    }
  }
  return nearest;
}

}  // namespace

void leaves_of(const BvhView& bvh, const BoundList& nodes, const QueryBox& outer, QueryBox& box, BoundList& near,
               BoundList& leaves) {
  const Lanes d;
  const IntLanes di;
  const std::array<float, 3> offset = displacement(outer.middle, box.middle);
  const Vec3Lanes middle = splat(box.middle);
  const Vec3Lanes half = splat(box.half);
  const BoundErrors errors(bvh, box);
  bound_as(outer, offset, bvh, box);
  const std::int32_t seed = nearest_leaf(bvh.nodes[nodes.child[lowest(nodes, offset).index()]], middle, half, errors);
  if (seed >= 0) {
    lower_bound_by_nearest(bvh, seed, box);
  }
  keep_near(nodes, offset, box, near);
  const Vec most = hn::Set(d, box.most);
  leaves.count = 0;
  leaves.make_room(bvh_width * near.count);
  for (std::size_t n = 0; n < near.count; ++n) {
    const std::int32_t number = near.child[n];
    const BvhNode& node = bvh.nodes[number];
    prefetch(bvh.nodes[near.child[std::min(n + 1, near.count - 1)]]);
    for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
      const Bound bound = bound_of_children(node, middle, half, errors, first);
      const auto wanted = hn::Le(least_in_box(d, bound.value, bound.slope.x, bound.slope.y, bound.slope.z, box), most);
      const auto is_leaf = hn::Lt(hn::Load(di, node.child.data() + first), hn::Zero(di));
      const auto child = hn::Iota(di, number * static_cast<std::int32_t>(bvh_width) + static_cast<std::int32_t>(first));
      append(bound, hn::And(wanted, hn::RebindMask(d, is_leaf)), child, leaves);
    }
  }
  close(leaves);
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(by_triangle);
HWY_EXPORT(nodes_of);
HWY_EXPORT(leaves_of);

void BoundList::make_room(std::size_t more) {
  const std::size_t needed = count + more + padding;
  if (needed > value.size()) {
    const std::size_t size = std::max<std::size_t>(2 * needed, 256);
    value.resize(size);
    for (std::vector<float>& lanes : slope) {
      lanes.resize(size);
    }
    child.resize(size);
  }
}

void bound_by_triangle(const BvhView& bvh, std::int32_t triangle, QueryBox& box) {
  HWY_DYNAMIC_DISPATCH(by_triangle)(bvh, triangle, box);
}

void list_nodes(const BvhView& bvh, const QueryBox& box, BoundList& nodes) {
  HWY_DYNAMIC_DISPATCH(nodes_of)(bvh, box, nodes);
}

void list_leaves(const BvhView& bvh, const BoundList& nodes, const QueryBox& outer, QueryBox& box, BoundList& near,
                 BoundList& leaves) {
  HWY_DYNAMIC_DISPATCH(leaves_of)(bvh, nodes, outer, box, near, leaves);
}

}  // namespace musclebench
#endif
