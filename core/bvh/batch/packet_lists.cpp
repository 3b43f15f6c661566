#include "core/bvh/batch/packet_lists.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/prefetch.hpp"

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/bvh/batch/packet_lists.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "core/bvh/batch/list_scan-inl.hpp"
#include "core/bvh/batch/packet_bounds-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

HWY_INLINE void append(const Bound& bound, hn::Mask<Lanes> mask, hn::Vec<IntLanes> what, BoundList& list) {
  const Lanes d;
  const IntLanes di;
  hn::StoreU(hn::Compress(bound.value, mask), d, list.value.data() + list.count);
  hn::StoreU(hn::Compress(bound.slope.x, mask), d, list.slope[0].data() + list.count);
  hn::StoreU(hn::Compress(bound.slope.y, mask), d, list.slope[1].data() + list.count);
  hn::StoreU(hn::Compress(bound.slope.z, mask), d, list.slope[2].data() + list.count);
  hn::StoreU(hn::Compress(what, hn::RebindMask(di, mask)), di, list.what.data() + list.count);
  list.count += hn::CountTrue(d, mask);
}

HWY_INLINE void close(BoundList& list) {
  const Wide w;
  list.make_room(0);
  for (std::size_t first = 0; first < BoundList::padding; first += hn::Lanes(w)) {
    hn::StoreU(hn::Set(w, packet_nowhere), w, list.value.data() + list.count + first);
    for (std::vector<float>& slope : list.slope) {
      hn::StoreU(hn::Zero(w), w, slope.data() + list.count + first);
    }
  }
}

std::array<float, 3> way_between(const std::array<float, 3>& from, const std::array<float, 3>& to) {
  return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

HWY_INLINE TriangleLanes triangle_of(const TreeView& tree, std::int32_t number) {
  return TriangleLanes::one(tree.leaves[static_cast<std::size_t>(number) / bvh_width],
                            static_cast<std::size_t>(number) % bvh_width);
}

HWY_INLINE float squared_length(const std::array<float, 3>& way) {
  return way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
}

/// By the place of one triangle that is the closest to the middle.
HWY_INLINE void lower_bound_by(const TreeView& tree, std::int32_t number, PlaceBox& box) {
  const TriangleLanes triangle = triangle_of(tree, number);
  const Arms arms = arms_to(triangle, splat(box.middle));
  const Vec3Lanes way = way_of(triangle, arms);
  const float sizes = hn::GetLane(sum_of_sizes(way)) + Errors(tree, box).reach;
  // The closest triangle may err the other way; and so may what is computed with this bound.
  const float most = hn::GetLane(arms.squared_length()) + tree.slack * (16 * sizes + 64 * tree.slack);
  if (most < box.most) {
    box.most = most;
    box.slope = {2 * hn::GetLane(way.x), 2 * hn::GetLane(way.y), 2 * hn::GetLane(way.z)};
  }
}

/// The same by the triangle of a leaf that is the nearest to the middle.
HWY_INLINE void lower_bound_by_nearest(const TreeView& tree, std::int32_t index, PlaceBox& box) {
  const Lanes d;
  const BvhLeaf& leaf = tree.leaves[index];
  alignas(64) BvhLanes squared;
  Vec least = hn::Set(d, packet_nowhere);
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
    lower_bound_by(tree, index * static_cast<std::int32_t>(bvh_width) + std::countr_zero(nearest), box);
  }
}

/// What the linear bound of a box says `way` from its middle, as one about that place.
void bound_as(const PlaceBox& box, const std::array<float, 3>& way, const TreeView& tree, PlaceBox& part) {
  float sizes = 0;
  part.most = box.most + squared_length(way);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    part.slope[axis] = box.slope[axis] + 2 * way[axis];
    part.most += box.slope[axis] * way[axis];
    sizes += std::abs(box.slope[axis]) + std::abs(way[axis]);
  }
  part.most += tree.slack * (sizes + tree.slack);
}

/// Those of a list that are near a box whose middle is `way` from the list's, with bounds about that.
HWY_INLINE void keep_near(const BoundList& list, const std::array<float, 3>& way, const PlaceBox& box,
                          BoundList& near) {
  const Wide w;
  const hn::RebindToSigned<Wide> wi;
  const WideVec squared_way = hn::Set(w, squared_length(way));
  near.count = 0;
  near.make_room(list.count);
  for (std::size_t start = 0; start < list.count; start += hn::Lanes(w)) {
    const WideVec value = hn::Add(hn::LoadU(w, list.value.data() + start), squared_way);
    const WideVec bounds = bounds_at(list, start, value, way);
    const auto slope = [&](std::size_t axis) HWY_ATTR {
      return hn::Add(hn::LoadU(w, list.slope[axis].data() + start), hn::Set(w, 2 * way[axis]));
    };
    const auto kept = hn::Le(least_in_box(w, bounds, slope(0), slope(1), slope(2), box), hn::Set(w, box.most));
    if (hn::AllFalse(w, kept)) {
      continue;
    }
    hn::StoreU(hn::Compress(bounds, kept), w, near.value.data() + near.count);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      hn::StoreU(hn::Compress(slope(axis), kept), w, near.slope[axis].data() + near.count);
    }
    hn::StoreU(hn::Compress(hn::LoadU(wi, list.what.data() + start), hn::RebindMask(wi, kept)), wi,
               near.what.data() + near.count);
    near.count += hn::CountTrue(w, kept);
  }
  close(near);
}

}  // namespace

void by_triangle(const TreeView& tree, std::int32_t triangle, PlaceBox& box) { lower_bound_by(tree, triangle, box); }

void nodes_of(const TreeView& tree, const PlaceBox& box, BoundList& nodes) {
  const Lanes d;
  const IntLanes di;
  const Errors errors(tree, box);
  const Vec3Lanes middle = splat(box.middle);
  const Vec3Lanes half = splat(box.half);
  const Vec most = hn::Set(d, box.most);
  // Those that only lead to others stay in the list, but nowhere.
  BoundList& waiting = nodes;
  waiting.count = 0;
  waiting.make_room(bvh_width);
  waiting.value[0] = -packet_nowhere;
  waiting.what[0] = 0;
  for (std::vector<float>& slope : waiting.slope) {
    slope[0] = 0;
  }
  waiting.count = 1;
  for (std::size_t next = 0; next < waiting.count; ++next) {
    const BvhNode& node = tree.nodes[waiting.what[next]];
    bool has_leaf = false;
    waiting.make_room(bvh_width);
    prefetch(tree.nodes[waiting.what[std::min(next + 2, waiting.count - 1)]]);
    for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
      const Bound bound = bound_of_children(node, middle, half, errors, first);
      const auto wanted = hn::Le(least_in_box(d, bound.value, bound.slope.x, bound.slope.y, bound.slope.z, box), most);
      const auto child = hn::Load(di, node.child.data() + first);
      const auto inner = hn::AndNot(hn::Lt(child, hn::Zero(di)), hn::RebindMask(di, wanted));
      append(bound, hn::RebindMask(d, inner), child, waiting);
      has_leaf = has_leaf || !hn::AllTrue(di, hn::Or(inner, hn::RebindMask(di, hn::Not(wanted))));
    }
    if (!has_leaf) {
      waiting.value[next] = packet_nowhere;
    }
  }
  close(nodes);
}

namespace {

/// The leaf below a node that is the nearest to the middle of the box; -1: none.
HWY_INLINE std::int32_t nearest_leaf(const BvhNode& node, const Vec3Lanes& middle, const Vec3Lanes& half,
                                     const Errors& errors) {
  const Lanes d;
  alignas(64) BvhLanes value;
  for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
    hn::Store(bound_of_children(node, middle, half, errors, first).value, d, value.data() + first);
  }
  std::int32_t nearest = -1;
  float least = packet_nowhere;
  for (std::size_t place = 0; place < bvh_width; ++place) {
    if (node.child[place] < 0 && value[place] < least) {
      least = value[place];
      nearest = ~node.child[place];
    }
  }
  return nearest;
}

}  // namespace

void leaves_of(const TreeView& tree, const BoundList& nodes, const PlaceBox& outer, PlaceBox& box, BoundList& near,
               BoundList& leaves) {
  const Lanes d;
  const IntLanes di;
  const std::array<float, 3> way = way_between(outer.middle, box.middle);
  const Vec3Lanes middle = splat(box.middle);
  const Vec3Lanes half = splat(box.half);
  const Errors errors(tree, box);
  bound_as(outer, way, tree, box);
  const std::int32_t seed = nearest_leaf(tree.nodes[nodes.what[lowest(nodes, way).place()]], middle, half, errors);
  if (seed >= 0) {
    lower_bound_by_nearest(tree, seed, box);
  }
  keep_near(nodes, way, box, near);
  const Vec most = hn::Set(d, box.most);
  leaves.count = 0;
  leaves.make_room(bvh_width * near.count);
  for (std::size_t n = 0; n < near.count; ++n) {
    const std::int32_t number = near.what[n];
    const BvhNode& node = tree.nodes[number];
    prefetch(tree.nodes[near.what[std::min(n + 1, near.count - 1)]]);
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
    what.resize(size);
  }
}

void bound_by_triangle(const TreeView& tree, std::int32_t triangle, PlaceBox& box) {
  HWY_DYNAMIC_DISPATCH(by_triangle)(tree, triangle, box);
}

void list_nodes(const TreeView& tree, const PlaceBox& box, BoundList& nodes) {
  HWY_DYNAMIC_DISPATCH(nodes_of)(tree, box, nodes);
}

void list_candidate_leaves(const TreeView& tree, const BoundList& nodes, const PlaceBox& outer, PlaceBox& box,
                           BoundList& near, BoundList& leaves) {
  HWY_DYNAMIC_DISPATCH(leaves_of)(tree, nodes, outer, box, near, leaves);
}

}  // namespace musclebench
#endif
