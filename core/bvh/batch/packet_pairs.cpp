#include "core/bvh/batch/packet_pairs.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/prefetch.hpp"

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/bvh/batch/packet_pairs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "core/bvh/batch/list_scan-inl.hpp"
#include "core/bvh/triangle_bvh_lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

/// Points, one a lane.
using PointLanes = PacketPoints::PointLanes;
using Points = hn::CappedTag<float, PacketPoints::capacity>;
using PointVec = hn::Vec<Points>;

HWY_INLINE PointVec load_points(const float* lanes) { return hn::Load(Points(), lanes); }

/// The points of a packet while leaves are looked into.
struct Asked {
  /// Squares that no float distance of the closest triangle exceeds.
  alignas(64) PointLanes limit;
  /// Squared distances, the least of each place.
  alignas(64) std::array<BvhLanes, PacketPoints::capacity> least;
};

HWY_INLINE void keep_least(Vec squared, BvhLanes& least, std::size_t first) {
  hn::Store(hn::Min(load(least, first), squared), Lanes(), least.data() + first);
}

/// The looks from the `first` on.
HWY_INLINE void look_from(const TreeView& tree, std::size_t first, PacketPoints& packet, Asked& asked) {
  const Lanes d;
  for (std::size_t look = first; look < packet.looks; ++look) {
    const BvhLeaf& leaf = tree.leaves[packet.leaf[look]];
    const auto n = static_cast<std::size_t>(packet.point[look]);
    const Vec3Lanes point = splat({packet.at[0][n], packet.at[1][n], packet.at[2][n]});
    for (std::size_t lane = 0; lane < bvh_width; lane += hn::Lanes(d)) {
      const Vec squared = arms_to(TriangleLanes::of(leaf, lane), point).squared_length();
      hn::Store(squared, d, packet.squared[look].to.data() + lane);
      if (leaf.slivers == 0) {
        keep_least(squared, asked.least[n], lane);
      }
    }
  }
}

/// Lowers the limits to what was seen, which is off by `slack` and `growth` times the distance.
HWY_INLINE void lower_limits(float slack, float growth, Asked& asked) {
  const Lanes d;
  const Points dp;
  alignas(64) PointLanes least;
  for (std::size_t n = 0; n < PacketPoints::capacity; ++n) {
    Vec smallest = load(asked.least[n], 0);
    for (std::size_t first = hn::Lanes(d); first < bvh_width; first += hn::Lanes(d)) {
      smallest = hn::Min(smallest, load(asked.least[n], first));
    }
    least[n] = hn::GetLane(hn::MinOfLanes(d, smallest));
  }
  for (std::size_t first = 0; first < PacketPoints::capacity; first += hn::Lanes(dp)) {
    const PointVec reach =
        hn::MulAdd(hn::Sqrt(load_points(least.data() + first)), hn::Set(dp, 1 + 2 * growth), hn::Set(dp, 2 * slack));
    const PointVec limit = hn::Mul(hn::Mul(reach, reach), hn::Set(dp, 1.000001F));
    hn::Store(hn::Min(load_points(asked.limit.data() + first), limit), dp, asked.limit.data() + first);
  }
}

/// What is known of the points before.
HWY_INLINE void start(const TreeView& tree, const PlaceBox& box, const PacketPoints& packet, Asked& asked) {
  const Points d;
  for (std::size_t first = 0; first < PacketPoints::capacity; first += hn::Lanes(d)) {
    PointVec limit = hn::Set(d, box.most);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const PointVec way = hn::Sub(load_points(packet.at[axis].data() + first), hn::Set(d, box.middle[axis]));
      limit = hn::MulAdd(hn::Add(hn::Set(d, box.slope[axis]), way), way, limit);
    }
    const PointVec rounding = hn::Add(hn::Sqrt(hn::Max(limit, hn::Zero(d))), hn::Set(d, tree.slack));
    hn::Store(hn::MulAdd(hn::Set(d, tree.slack), rounding, limit), d, asked.limit.data() + first);
  }
  // Nothing is near points that are not there.
  for (std::size_t n = packet.count; n < PacketPoints::capacity; ++n) {
    asked.limit[n] = -packet_nowhere;
  }
  for (BvhLanes& least : asked.least) {
    least.fill(packet_nowhere);
  }
}

HWY_INLINE std::int32_t leaf_at(const TreeView& tree, std::int32_t child) {
  return ~tree.nodes[static_cast<std::size_t>(child) / bvh_width].child[static_cast<std::size_t>(child) % bvh_width];
}

/// Between two points, from the middle of the box.
HWY_INLINE std::array<float, 3> way_to_middle(const PacketPoints& packet, std::size_t first, std::size_t last,
                                              const PlaceBox& box) {
  std::array<float, 3> way{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    way[axis] = 0.5F * (packet.at[axis][first] + packet.at[axis][last]) - box.middle[axis];
  }
  return way;
}

/// By their bounds the leaf that is the nearest to the first points and that to the other ones; where it is the same,
/// one that is nearly as near, or the same twice where there is only one.
HWY_INLINE std::array<std::int32_t, 2> nearest_leaves(const TreeView& tree, const BoundList& leaves,
                                                      const PlaceBox& box, const PacketPoints& packet) {
  const std::size_t others = packet.first_count == packet.count ? 0 : packet.first_count;
  const std::array<float, 3> way = way_to_middle(packet, 0, packet.first_count - 1, box);
  const std::array<float, 3> other_way = way_to_middle(packet, others, packet.count - 1, box);
  Lowest lowest;
  Lowest lowest_of_others;
  for (std::size_t first = 0; first < leaves.count; first += hn::Lanes(Wide())) {
    const WideVec value = hn::LoadU(Wide(), leaves.value.data() + first);
    lowest.look(bounds_at(leaves, first, value, way), first);
    lowest_of_others.look(bounds_at(leaves, first, value, other_way), first);
  }
  const auto [nearest, second] = lowest.two_places();
  const std::size_t of_others = lowest_of_others.place();
  return {leaf_at(tree, leaves.what[nearest]), leaf_at(tree, leaves.what[of_others == nearest ? second : of_others])};
}

/// Lists the leaves whose bound is within the limit of any of the points; returns how many. A leaf that holds what is
/// the closest at r from the middle is within S = sqrt(limit) + |r| of the middle, and S is at most 4 R (R and u as in
/// triangle_bvh_search.cpp). The closest may be by the slack farther than in floats, which is 2 slack S here; places
/// rounded by slack / 10 move a bound by 0.4 slack S; eight sums and products of at most 3 S^2 err by 24 u S^2, which
/// is 2 slack S.
HWY_INLINE std::size_t leaves_near_any(const TreeView& tree, const BoundList& leaves, const PlaceBox& box,
                                       const Asked& asked, PacketPoints& packet) {
  const Points d;
  const Wide w;
  const hn::RebindToSigned<Wide> wi;
  alignas(64) std::array<PointLanes, 3> way;
  alignas(64) PointLanes most;
  for (std::size_t first = 0; first < PacketPoints::capacity; first += hn::Lanes(d)) {
    PointVec squared_way = hn::Zero(d);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const PointVec part = hn::Sub(load_points(packet.at[axis].data() + first), hn::Set(d, box.middle[axis]));
      hn::Store(part, d, way[axis].data() + first);
      squared_way = hn::MulAdd(part, part, squared_way);
    }
    const PointVec limit = load_points(asked.limit.data() + first);
    const PointVec sizes = hn::Add(hn::Sqrt(hn::Max(limit, hn::Zero(d))), hn::Sqrt(squared_way));
    const PointVec rounding = hn::Mul(hn::Set(d, 6 * tree.slack), hn::Add(sizes, hn::Set(d, tree.slack)));
    hn::Store(hn::Add(hn::Sub(limit, squared_way), rounding), d, most.data() + first);
  }
  std::size_t count = 0;
  for (std::size_t start = 0; start < leaves.count; start += hn::Lanes(w)) {
    const WideVec value = hn::LoadU(w, leaves.value.data() + start);
    const WideVec x = hn::LoadU(w, leaves.slope[0].data() + start);
    const WideVec y = hn::LoadU(w, leaves.slope[1].data() + start);
    const WideVec z = hn::LoadU(w, leaves.slope[2].data() + start);
    WideVec highest = hn::Set(w, -packet_nowhere);  // that a value may be
    for (std::size_t n = 0; n < packet.count; ++n) {
      highest =
          hn::Max(highest, hn::NegMulAdd(z, hn::Set(w, way[2][n]),
                                         hn::NegMulAdd(y, hn::Set(w, way[1][n]),
                                                       hn::NegMulAdd(x, hn::Set(w, way[0][n]), hn::Set(w, most[n])))));
    }
    const auto kept = hn::RebindMask(wi, hn::Le(value, highest));
    hn::StoreU(hn::Compress(hn::LoadU(wi, leaves.what.data() + start), kept), wi, packet.near.data() + count);
    count += hn::CountTrue(wi, kept);
  }
  return count;
}

/// Squared distances of points, one a lane, to the turned box of one child.
HWY_INLINE PointVec squared_to_box(const BvhNode& node, std::size_t place, const Vec3Of<PointVec>& point) {
  const Points d;
  const auto one = [&](const std::array<BvhLanes, 3>& lanes) HWY_ATTR {
    return Vec3Of<PointVec>{hn::Set(d, lanes[0][place]), hn::Set(d, lanes[1][place]), hn::Set(d, lanes[2][place])};
  };
  const auto beyond = [&](PointVec at, const BvhLanes& lower, const BvhLanes& upper) HWY_ATTR {
    const PointVec out = hn::Max(hn::Sub(hn::Set(d, lower[place]), at), hn::Sub(at, hn::Set(d, upper[place])));
    return hn::Max(out, hn::Zero(d));
  };
  const Vec3Of<PointVec> normal = one(node.normal);
  const Vec3Of<PointVec> tangent = one(node.tangent);
  const Vec3Of<PointVec> out{beyond(dot(normal, point), node.slab_lower, node.slab_upper),
                             beyond(dot(tangent, point), node.side_lower[0], node.side_upper[0]),
                             beyond(dot(cross(normal, tangent), point), node.side_lower[1], node.side_upper[1])};
  return dot(out, out);
}

HWY_INLINE void add_looks_of_all(std::int32_t leaf, PacketPoints& packet) {
  for (std::size_t n = 0; n < packet.count; ++n) {
    packet.leaf[packet.looks] = leaf;
    packet.point[packet.looks++] = static_cast<std::int32_t>(n);
  }
}

/// Adds looks into the leaves listed as near whose box is within the limit of a point, but not into the `known`.
HWY_INLINE void add_looks(const TreeView& tree, std::size_t near, const std::array<std::int32_t, 2>& known,
                          const Asked& asked, PacketPoints& packet) {
  const Points d;
  const hn::RebindToSigned<Points> di;
  std::size_t looks = packet.looks;
  std::int32_t* HWY_RESTRICT points_of = packet.point.data();
  std::int32_t* HWY_RESTRICT leaf_of = packet.leaf.data();
  for (std::size_t l = 0; l < near; ++l) {
    const auto child = static_cast<std::size_t>(packet.near[l]);
    const BvhNode& node = tree.nodes[child / bvh_width];
    const std::int32_t leaf = ~node.child[child % bvh_width];
    if (leaf == known[0] || leaf == known[1]) {
      continue;
    }
    for (std::size_t first = 0; first < PacketPoints::capacity; first += hn::Lanes(d)) {
      const Vec3Of<PointVec> at{load_points(packet.at[0].data() + first), load_points(packet.at[1].data() + first),
                                load_points(packet.at[2].data() + first)};
      const PointVec squared = squared_to_box(node, child % bvh_width, at);
      const auto kept = hn::RebindMask(di, hn::Le(squared, load_points(asked.limit.data() + first)));
      const auto points = hn::Iota(di, static_cast<std::int32_t>(first));
      hn::StoreU(hn::Compress(points, kept), di, points_of + looks);
      hn::StoreU(hn::Set(di, leaf), di, leaf_of + looks);
      looks += hn::CountTrue(di, kept);
    }
    prefetch(tree.leaves[leaf]);
  }
  packet.looks = looks;
}

HWY_INLINE void add_pairs(const TreeView& tree, const Asked& asked, PacketPoints& packet, CandidatePairs& pairs) {
  const Lanes d;
  const IntLanes di;
  pairs.make_room(bvh_width * (packet.looks + 1));
  for (std::size_t look = 0; look < packet.looks; ++look) {
    const BvhLeaf& leaf = tree.leaves[packet.leaf[look]];
    const auto n = static_cast<std::size_t>(packet.point[look]);
    const Vec limit = hn::Set(d, asked.limit[n]);
    for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
      const auto near = hn::RebindMask(di, hn::Le(load(packet.squared[look].to, first), limit));
      if (hn::AllFalse(di, near)) {
        continue;
      }
      hn::StoreU(hn::Compress(hn::Load(di, leaf.triangle.data() + first), near), di,
                 pairs.triangle.data() + pairs.count);
      hn::StoreU(hn::Set(di, packet.number[n]), di, pairs.point.data() + pairs.count);
      pairs.count += hn::CountTrue(di, near);
    }
  }
}

}  // namespace

void pairs_of(const TreeView& tree, const BoundList& leaves, const PlaceBox& box, PacketPoints& packet,
              CandidatePairs& pairs) {
  if (leaves.count == 0) {
    return;
  }
  // Step by step for all points, so that the CPU need not wait for one of them.
  packet.make_room(leaves.count);
  Asked asked;
  start(tree, box, packet, asked);
  const std::array<std::int32_t, 2> nearest = nearest_leaves(tree, leaves, box, packet);
  packet.looks = 0;
  for (std::size_t l = 0; l < (nearest[0] == nearest[1] ? 1 : 2); ++l) {
    add_looks_of_all(nearest[l], packet);
  }
  const std::size_t first_looks = packet.looks;
  look_from(tree, 0, packet, asked);
  lower_limits(tree.slack, 0, asked);
  add_looks(tree, leaves_near_any(tree, leaves, box, asked, packet), nearest, asked, packet);
  look_from(tree, first_looks, packet, asked);
  lower_limits(tree.near_slack, tree.slack_growth, asked);  // nothing is compared with boxes any more
  add_pairs(tree, asked, packet, pairs);
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(pairs_of);

void PacketPoints::make_room(std::size_t leaves) {
  const std::size_t needed = leaves + BoundList::padding;
  if (needed > near.size()) {
    near.resize(2 * needed);
    leaf.resize(2 * capacity * needed);
    point.resize(2 * capacity * needed);
    squared.resize(2 * capacity * needed);
  }
}

void CandidatePairs::make_room(std::size_t more) {
  if (count + more > point.size()) {
    point.resize(2 * (count + more));
    triangle.resize(2 * (count + more));
  }
}

void list_pairs(const TreeView& tree, const BoundList& leaves, const PlaceBox& box, PacketPoints& packet,
                CandidatePairs& pairs) {
  HWY_DYNAMIC_DISPATCH(pairs_of)(tree, leaves, box, packet, pairs);
}

}  // namespace musclebench
#endif
