#include "backends/sdf/packet_pairs.hpp"

#include <algorithm>
#include <cmath>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/sdf/packet_pairs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "backends/sdf/list_scan-inl.hpp"
#include "core/geometry/triangle_tree_lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
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
  Lowest lowest;
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
    lowest.look(sum, start);
  }
  return lowest.place();
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

HWY_EXPORT(pairs_of);

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

void list_pairs(const TreeView& tree, const LeafBoxes& leaves, const PlaceBox& box, PacketPoints& packet,
                std::int32_t first, CandidatePairs& pairs) {
  HWY_DYNAMIC_DISPATCH(pairs_of)(tree, leaves, box, packet, first, pairs);
}

}  // namespace musclebench
#endif
