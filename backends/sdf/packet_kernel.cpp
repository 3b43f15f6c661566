#include "backends/sdf/packet_kernel.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/sdf/packet_kernel.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "core/geometry/triangle_tree_lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

/// Lists are scanned with what the CPU has.
using Wide = hn::CappedTag<float, BoundList::padding>;
using WideVec = hn::Vec<Wide>;

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
// Rounding: the slack bounds how far a float distance is off (triangle_tree_search.cpp); w and q are within 4 of it,
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

HWY_INLINE Bound bound_of_children(const TreeNode& node, const Vec3Lanes& middle, const Vec3Lanes& half,
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

/// The bounds from `first` on at `way` from the middle of the list's box.
HWY_INLINE WideVec bounds_at(const BoundList& list, std::size_t first, WideVec from, const std::array<float, 3>& way) {
  const Wide w;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    from = hn::MulAdd(hn::LoadU(w, list.slope[axis].data() + first), hn::Set(w, way[axis]), from);
  }
  return from;
}

/// The place in a list that is not empty with the lowest bound.
HWY_INLINE std::size_t lowest(const BoundList& list, const std::array<float, 3>& way) {
  const Wide w;
  const hn::RebindToSigned<Wide> wi;
  WideVec least = hn::Set(w, packet_nowhere);
  auto place = hn::Zero(wi);
  for (std::size_t first = 0; first < list.count; first += hn::Lanes(w)) {
    const WideVec bound = bounds_at(list, first, hn::LoadU(w, list.value.data() + first), way);
    const auto lower = hn::Lt(bound, least);
    least = hn::IfThenElse(lower, bound, least);
    place = hn::IfThenElse(hn::RebindMask(wi, lower), hn::Set(wi, static_cast<std::int32_t>(first)), place);
  }
  const auto lanes = hn::RebindMask(wi, hn::Eq(least, hn::MinOfLanes(w, least)));
  const auto lane = static_cast<std::size_t>(hn::FindFirstTrue(wi, lanes));
  alignas(64) std::int32_t start[BoundList::padding];
  hn::Store(place, wi, start);
  return static_cast<std::size_t>(start[lane]) + lane;
}

std::array<float, 3> way_between(const std::array<float, 3>& from, const std::array<float, 3>& to) {
  return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

HWY_INLINE TriangleLanes triangle_of(const TreeView& tree, std::int32_t number) {
  return TriangleLanes::one(tree.leaves[static_cast<std::size_t>(number) / tree_width],
                            static_cast<std::size_t>(number) % tree_width);
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
  const TreeLeaf& leaf = tree.leaves[index];
  alignas(64) TreeLanes squared;
  Vec least = hn::Set(d, packet_nowhere);
  for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
    const Vec part = arms_to(TriangleLanes::of(leaf, first), splat(box.middle)).squared_length();
    hn::Store(part, d, squared.data() + first);
    least = hn::Min(least, part);
  }
  const Vec limit = hn::MinOfLanes(d, least);
  unsigned nearest = 0;
  for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
    nearest |= bits_of(d, hn::Le(load(squared, first), limit), first);
  }
  nearest &= ~leaf.needles;
  if (nearest != 0) {
    lower_bound_by(tree, index * static_cast<std::int32_t>(tree_width) + std::countr_zero(nearest), box);
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
  waiting.make_room(tree_width);
  waiting.value[0] = -packet_nowhere;
  waiting.what[0] = 0;
  for (std::vector<float>& slope : waiting.slope) {
    slope[0] = 0;
  }
  waiting.count = 1;
  for (std::size_t next = 0; next < waiting.count; ++next) {
    const TreeNode& node = tree.nodes[waiting.what[next]];
    bool has_leaf = false;
    waiting.make_room(tree_width);
    for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
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
HWY_INLINE std::int32_t nearest_leaf(const TreeNode& node, const Vec3Lanes& middle, const Vec3Lanes& half,
                                     const Errors& errors) {
  const Lanes d;
  alignas(64) TreeLanes value;
  for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
    hn::Store(bound_of_children(node, middle, half, errors, first).value, d, value.data() + first);
  }
  std::int32_t nearest = -1;
  float least = packet_nowhere;
  for (std::size_t place = 0; place < tree_width; ++place) {
    if (node.child[place] < 0 && value[place] < least) {
      least = value[place];
      nearest = ~node.child[place];
    }
  }
  return nearest;
}

HWY_INLINE void append_boxes(const TreeNode& node, hn::Vec<IntLanes> child, hn::Mask<Lanes> listed, std::size_t first,
                             LeafBoxes& leaves) {
  const Lanes d;
  const IntLanes di;
  const auto put = [&](Vec lanes, std::vector<float>& list)
                       HWY_ATTR { hn::StoreU(hn::Compress(lanes, listed), d, list.data() + leaves.count); };
  const Vec3Lanes normal = load(node.normal, first);
  const Vec3Lanes tangent = load(node.tangent, first);
  const std::array<Vec3Lanes, 3> axes{normal, tangent, cross(normal, tangent)};
  const std::array<const TreeLanes*, 3> lower{&node.slab_lower, &node.side_lower[0], &node.side_lower[1]};
  const std::array<const TreeLanes*, 3> upper{&node.slab_upper, &node.side_upper[0], &node.side_upper[1]};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(axes[axis].x, leaves.axis[axis][0]);
    put(axes[axis].y, leaves.axis[axis][1]);
    put(axes[axis].z, leaves.axis[axis][2]);
    put(load(*lower[axis], first), leaves.lower[axis]);
    put(load(*upper[axis], first), leaves.upper[axis]);
  }
  hn::StoreU(hn::Compress(hn::Not(child), hn::RebindMask(di, listed)), di, leaves.leaf.data() + leaves.count);
  leaves.count += hn::CountTrue(d, listed);
}

template <typename Item>
HWY_INLINE void prefetch(const Item& item) {
  for (std::size_t offset = 0; offset < sizeof(Item); offset += 64) {
    hwy::Prefetch(reinterpret_cast<const unsigned char*>(&item) + offset);
  }
}

}  // namespace

void leaves_of(const TreeView& tree, const BoundList& nodes, const PlaceBox& outer, PlaceBox& box, BoundList& near,
               LeafBoxes& leaves) {
  const Lanes d;
  const IntLanes di;
  const std::array<float, 3> way = way_between(outer.middle, box.middle);
  const Vec3Lanes middle = splat(box.middle);
  const Vec3Lanes half = splat(box.half);
  const Errors errors(tree, box);
  bound_as(outer, way, tree, box);
  const std::int32_t seed = nearest_leaf(tree.nodes[nodes.what[lowest(nodes, way)]], middle, half, errors);
  if (seed >= 0) {
    lower_bound_by_nearest(tree, seed, box);
  }
  keep_near(nodes, way, box, near);
  const Vec most = hn::Set(d, box.most);
  leaves.count = 0;
  leaves.make_room(tree_width * near.count);
  for (std::size_t n = 0; n < near.count; ++n) {
    const TreeNode& node = tree.nodes[near.what[n]];
    prefetch(tree.nodes[near.what[std::min(n + 1, near.count - 1)]]);
    for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
      const Bound bound = bound_of_children(node, middle, half, errors, first);
      const auto wanted = hn::Le(least_in_box(d, bound.value, bound.slope.x, bound.slope.y, bound.slope.z, box), most);
      const auto child = hn::Load(di, node.child.data() + first);
      const auto listed = hn::And(wanted, hn::RebindMask(d, hn::Lt(child, hn::Zero(di))));
      append_boxes(node, child, listed, first, leaves);
    }
  }
  const Wide w;
  for (std::size_t first = 0; first < LeafBoxes::padding; first += hn::Lanes(w)) {
    hn::StoreU(hn::Set(w, tree_nowhere), w, leaves.lower[0].data() + leaves.count + first);
  }
}

namespace {

/// The points of a packet while leaves are looked into.
struct Asked {
  alignas(64) TreeLanes limit;  ///< square that no float distance of the closest triangle exceeds
  alignas(64) std::array<TreeLanes, PacketPoints::capacity> least;  ///< squared distances, the least of each place
};

HWY_INLINE void look_into(const TreeView& tree, const PacketPoints& packet, PacketPoints::Look& look, Asked& asked) {
  const Lanes d;
  const TreeLeaf& leaf = tree.leaves[look.leaf];
  const auto n = static_cast<std::size_t>(look.point);
  const Vec3Lanes point = splat({packet.at[0][n], packet.at[1][n], packet.at[2][n]});
  for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
    const Vec squared = arms_to(TriangleLanes::of(leaf, first), point).squared_length();
    hn::Store(squared, d, look.squared.data() + first);
    if (leaf.needles == 0) {
      hn::Store(hn::Min(load(asked.least[n], first), squared), d, asked.least[n].data() + first);
    }
  }
}

/// Lowers the limits to what was seen.
HWY_INLINE void lower_limits(const TreeView& tree, Asked& asked) {
  const Lanes d;
  alignas(64) TreeLanes least;
  for (std::size_t n = 0; n < PacketPoints::capacity; ++n) {
    Vec smallest = load(asked.least[n], 0);
    for (std::size_t first = hn::Lanes(d); first < tree_width; first += hn::Lanes(d)) {
      smallest = hn::Min(smallest, load(asked.least[n], first));
    }
    least[n] = hn::GetLane(hn::MinOfLanes(d, smallest));
  }
  for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
    const Vec reach = hn::Add(hn::Sqrt(load(least, first)), hn::Set(d, 2 * tree.slack));
    const Vec limit = hn::Mul(hn::Mul(reach, reach), hn::Set(d, 1.000001F));
    hn::Store(hn::Min(load(asked.limit, first), limit), d, asked.limit.data() + first);
  }
}

/// What is known of the points before.
HWY_INLINE void start(const TreeView& tree, const PlaceBox& box, const PacketPoints& packet, Asked& asked) {
  const Lanes d;
  for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
    Vec limit = hn::Set(d, box.most);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Vec way = hn::Sub(load(packet.at[axis], first), hn::Set(d, box.middle[axis]));
      limit = hn::MulAdd(hn::Add(hn::Set(d, box.slope[axis]), way), way, limit);
    }
    const Vec rounding = hn::Add(hn::Sqrt(hn::Max(limit, hn::Zero(d))), hn::Set(d, tree.slack));
    hn::Store(hn::MulAdd(hn::Set(d, tree.slack), rounding, limit), d, asked.limit.data() + first);
  }
  for (TreeLanes& least : asked.least) {
    for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
      hn::Store(hn::Set(d, packet_nowhere), d, least.data() + first);
    }
  }
}

/// Squared distances of a point to the boxes of leaves; returns the place of the nearest one.
HWY_INLINE std::size_t look_at(const LeafBoxes& leaves, const std::array<float, 3>& point,
                               float* HWY_RESTRICT squared) {
  const Wide w;
  const hn::RebindToSigned<Wide> wi;
  WideVec least = hn::Set(w, packet_nowhere);
  auto place = hn::Zero(wi);
  for (std::size_t start = 0; start < leaves.count; start += hn::Lanes(w)) {
    const auto lanes = [&](const std::vector<float>& list) HWY_ATTR { return hn::LoadU(w, list.data() + start); };
    WideVec sum = hn::Zero(w);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto& direction = leaves.axis[axis];
      WideVec at = hn::Mul(lanes(direction[0]), hn::Set(w, point[0]));
      at = hn::MulAdd(lanes(direction[1]), hn::Set(w, point[1]), at);
      at = hn::MulAdd(lanes(direction[2]), hn::Set(w, point[2]), at);
      const WideVec out =
          hn::Max(hn::Max(hn::Sub(lanes(leaves.lower[axis]), at), hn::Sub(at, lanes(leaves.upper[axis]))), hn::Zero(w));
      sum = hn::MulAdd(out, out, sum);
    }
    hn::StoreU(sum, w, squared + start);
    const auto lower = hn::Lt(sum, least);
    least = hn::IfThenElse(lower, sum, least);
    place = hn::IfThenElse(hn::RebindMask(wi, lower), hn::Set(wi, static_cast<std::int32_t>(start)), place);
  }
  const auto lane =
      static_cast<std::size_t>(hn::FindFirstTrue(wi, hn::RebindMask(wi, hn::Eq(least, hn::MinOfLanes(w, least)))));
  alignas(64) std::int32_t start[LeafBoxes::padding];
  hn::Store(place, wi, start);
  return static_cast<std::size_t>(start[lane]) + lane;
}

/// Adds looks into those whose box is within the limit, but not `known`.
HWY_INLINE void leaves_within(const LeafBoxes& leaves, const float* HWY_RESTRICT squared, float limit,
                              std::int32_t known, std::int32_t point, PacketPoints& packet) {
  const Wide w;
  const hn::RebindToSigned<Wide> wi;
  for (std::size_t start = 0; start < leaves.count; start += hn::Lanes(w)) {
    const auto leaf = hn::LoadU(wi, leaves.leaf.data() + start);
    const auto near = hn::Le(hn::LoadU(w, squared + start), hn::Set(w, limit));
    const auto kept = hn::AndNot(hn::Eq(leaf, hn::Set(wi, known)), hn::RebindMask(wi, near));
    hn::StoreU(hn::Compress(leaf, kept), wi, packet.next_leaf.data() + packet.next);
    hn::StoreU(hn::Set(wi, point), wi, packet.next_point.data() + packet.next);
    packet.next += hn::CountTrue(wi, kept);
  }
}

}  // namespace

void pairs_of(const TreeView& tree, const LeafBoxes& leaves, const PlaceBox& box, PacketPoints& packet,
              std::int32_t first_point, CandidatePairs& pairs) {
  const Lanes d;
  const IntLanes di;
  if (leaves.count == 0) {
    return;
  }
  // Step by step for all points, so that the CPU need not wait for one of them.
  packet.make_room(leaves.count);
  const std::size_t boxes = leaves.count + LeafBoxes::padding;
  Asked asked;
  start(tree, box, packet, asked);
  for (std::size_t n = 0; n < packet.count; ++n) {
    const std::size_t nearest =
        look_at(leaves, {packet.at[0][n], packet.at[1][n], packet.at[2][n]}, packet.to_box.data() + n * boxes);
    packet.look[n].leaf = leaves.leaf[nearest];
    packet.look[n].point = static_cast<std::int32_t>(n);
  }
  for (std::size_t n = 0; n < packet.count; ++n) {
    look_into(tree, packet, packet.look[n], asked);
  }
  lower_limits(tree, asked);
  packet.next = 0;
  for (std::size_t n = 0; n < packet.count; ++n) {
    leaves_within(leaves, packet.to_box.data() + n * boxes, asked.limit[n], packet.look[n].leaf,
                  static_cast<std::int32_t>(n), packet);
  }
  const std::size_t looks = packet.count + packet.next;
  for (std::size_t l = packet.count; l < looks; ++l) {
    packet.look[l].leaf = packet.next_leaf[l - packet.count];
    packet.look[l].point = packet.next_point[l - packet.count];
    look_into(tree, packet, packet.look[l], asked);
  }
  lower_limits(tree, asked);
  pairs.make_room(tree_width * (looks + 1));
  std::size_t count = pairs.count;
  std::int32_t* HWY_RESTRICT triangles = pairs.triangle.data();
  std::int32_t* HWY_RESTRICT points = pairs.point.data();
  for (std::size_t l = 0; l < looks; ++l) {
    const PacketPoints::Look& look = packet.look[l];
    const TreeLeaf& leaf = tree.leaves[look.leaf];
    const Vec limit = hn::Set(d, asked.limit[static_cast<std::size_t>(look.point)]);
    for (std::size_t first = 0; first < tree_width; first += hn::Lanes(d)) {
      const auto near = hn::Le(load(look.squared, first), limit);
      const auto triangle = hn::Load(di, leaf.triangle.data() + first);
      hn::StoreU(hn::Compress(triangle, hn::RebindMask(di, near)), di, triangles + count);
      hn::StoreU(hn::Set(di, first_point + look.point), di, points + count);
      count += hn::CountTrue(d, near);
    }
  }
  pairs.count = count;
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(by_triangle);
HWY_EXPORT(nodes_of);
HWY_EXPORT(leaves_of);
HWY_EXPORT(pairs_of);

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

void LeafBoxes::make_room(std::size_t more) {
  const std::size_t needed = count + more + padding;
  if (needed > leaf.size()) {
    const std::size_t size = std::max<std::size_t>(2 * needed, 256);
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::vector<float>& lanes : axis[a]) {
        lanes.resize(size);
      }
      lower[a].resize(size);
      upper[a].resize(size);
    }
    leaf.resize(size);
  }
}

void PacketPoints::make_room(std::size_t leaves) {
  const std::size_t needed = capacity * (leaves + LeafBoxes::padding);
  if (needed > look.size()) {
    look.resize(2 * needed);
    next_leaf.resize(2 * needed);
    next_point.resize(2 * needed);
    to_box.resize(2 * needed);
  }
}

void CandidatePairs::make_room(std::size_t more) {
  if (count + more > point.size()) {
    point.resize(2 * (count + more));
    triangle.resize(2 * (count + more));
  }
}

void bound_by_triangle(const TreeView& tree, std::int32_t triangle, PlaceBox& box) {
  HWY_DYNAMIC_DISPATCH(by_triangle)(tree, triangle, box);
}

void list_nodes(const TreeView& tree, const PlaceBox& box, BoundList& nodes) {
  HWY_DYNAMIC_DISPATCH(nodes_of)(tree, box, nodes);
}

void list_leaves(const TreeView& tree, const BoundList& nodes, const PlaceBox& outer, PlaceBox& box, BoundList& near,
                 LeafBoxes& leaves) {
  HWY_DYNAMIC_DISPATCH(leaves_of)(tree, nodes, outer, box, near, leaves);
}

void list_pairs(const TreeView& tree, const LeafBoxes& leaves, const PlaceBox& box, PacketPoints& packet,
                std::int32_t first, CandidatePairs& pairs) {
  HWY_DYNAMIC_DISPATCH(pairs_of)(tree, leaves, box, packet, first, pairs);
}

}  // namespace musclebench
#endif
