#include "core/bvh/batch/candidate_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/prefetch.hpp"

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/bvh/batch/candidate_pairs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "core/bvh/batch/list_scan-inl.hpp"
#include "core/bvh/triangle_bvh_lanes-inl.hpp"
#include "core/bvh/triangle_bvh_nodes.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

/// Points, one a lane.
using PointLanes = QueryBatch::PointLanes;
using Points = hn::CappedTag<float, QueryBatch::capacity>;
using PointVec = hn::Vec<Points>;

HWY_INLINE PointVec load_points(const float* lanes) { return hn::Load(Points(), lanes); }

/// What is known of the distances of a batch's points while candidate leaves are measured.
struct PointLimits {
  /// No squared distance to a point's closest triangle, in single precision, exceeds its limit.
  alignas(64) PointLanes limit;
  /// The least squared distance of each point so far, a lane of a leaf each.
  alignas(64) std::array<BvhLanes, QueryBatch::capacity> least;
};

HWY_INLINE void keep_least(Vec squared, BvhLanes& least, std::size_t first) {
  hn::Store(hn::Min(load(least, first), squared), Lanes(), least.data() + first);
}

/// Computes the squared distances of the pairs from `first` on. Those of one leaf follow each other, so that its
/// triangles stay in registers.
HWY_INLINE void measure_pairs(const BvhView& bvh, std::size_t first, QueryBatch& batch, PointLimits& limits) {
  const Lanes d;
  const std::int32_t* HWY_RESTRICT leaf_of = batch.leaf.data();
  const std::int32_t* HWY_RESTRICT point_of = batch.point.data();
  QueryBatch::Squared* HWY_RESTRICT squared_of = batch.squared.data();
  const std::size_t pairs = batch.pairs;
  for (std::size_t begin = first, end = first; begin < pairs; begin = end) {
    while (end < pairs && leaf_of[end] == leaf_of[begin]) ++end;
    const BvhLeaf& leaf = bvh.leaves[leaf_of[begin]];
    for (std::size_t lane = 0; lane < bvh_width; lane += hn::Lanes(d)) {
      const TriangleLanes triangles = TriangleLanes::of(leaf, lane);
      for (std::size_t pair = begin; pair < end; ++pair) {
        const auto n = static_cast<std::size_t>(point_of[pair]);
        const Vec squared =
            arms_to(triangles, splat({batch.at[0][n], batch.at[1][n], batch.at[2][n]})).squared_length();
        hn::Store(squared, d, squared_of[pair].to.data() + lane);
        if (leaf.slivers == 0) {
          keep_least(squared, limits.least[n], lane);
        }
      }
    }
  }
}

/// Lowers the limits to the least distances, which are off by `slack` and `growth` times the distance.
HWY_INLINE void lower_limits(float slack, float growth, PointLimits& limits) {
  const Lanes d;
  const Points dp;
  alignas(64) PointLanes least;
  for (std::size_t n = 0; n < QueryBatch::capacity; ++n) {
    Vec smallest = load(limits.least[n], 0);
    for (std::size_t first = hn::Lanes(d); first < bvh_width; first += hn::Lanes(d)) {
      smallest = hn::Min(smallest, load(limits.least[n], first));
    }
    least[n] = hn::GetLane(hn::MinOfLanes(d, smallest));
  }
  for (std::size_t first = 0; first < QueryBatch::capacity; first += hn::Lanes(dp)) {
    const PointVec reach =
        hn::MulAdd(hn::Sqrt(load_points(least.data() + first)), hn::Set(dp, 1 + 2 * growth), hn::Set(dp, 2 * slack));
    const PointVec limit = hn::Mul(hn::Mul(reach, reach), hn::Set(dp, 1.000001F));
    hn::Store(hn::Min(load_points(limits.limit.data() + first), limit), dp, limits.limit.data() + first);
  }
}

/// The limits that the upper bound of the box gives.
HWY_INLINE void start(const BvhView& bvh, const QueryBox& box, const QueryBatch& batch, PointLimits& limits) {
  const Points d;
  for (std::size_t first = 0; first < QueryBatch::capacity; first += hn::Lanes(d)) {
    PointVec limit = hn::Set(d, box.most);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const PointVec offset = hn::Sub(load_points(batch.at[axis].data() + first), hn::Set(d, box.middle[axis]));
      limit = hn::MulAdd(hn::Add(hn::Set(d, box.slope[axis]), offset), offset, limit);
    }
    const PointVec rounding = hn::Add(hn::Sqrt(hn::Max(limit, hn::Zero(d))), hn::Set(d, bvh.slack));
    hn::Store(hn::MulAdd(hn::Set(d, bvh.slack), rounding, limit), d, limits.limit.data() + first);
  }
  // Padding lanes match no leaf.
  for (std::size_t n = batch.count; n < QueryBatch::capacity; ++n) {
    limits.limit[n] = -far_away;
  }
  for (BvhLanes& least : limits.least) {
    least.fill(far_away);
  }
}

HWY_INLINE std::int32_t leaf_at(const BvhView& bvh, std::int32_t child) {
  return ~bvh.nodes[static_cast<std::size_t>(child) / bvh_width].child[static_cast<std::size_t>(child) % bvh_width];
}

/// From the middle of the box to the midpoint of two points.
HWY_INLINE std::array<float, 3> offset_of_midpoint(const QueryBatch& batch, std::size_t first, std::size_t last,
                                                   const QueryBox& box) {
  std::array<float, 3> offset{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    offset[axis] = 0.5F * (batch.at[axis][first] + batch.at[axis][last]) - box.middle[axis];
  }
  return offset;
}

/// The leaf with the lowest bound for the first points, as many as `first_count`, and the one for the others'; where
/// these are the same, a leaf that is nearly as near, or the same twice where the list has only one.
HWY_INLINE std::array<std::int32_t, 2> nearest_leaves(const BvhView& bvh, const BoundList& leaves, const QueryBox& box,
                                                      const QueryBatch& batch) {
  const std::size_t others = batch.first_count == batch.count ? 0 : batch.first_count;
  const std::array<float, 3> offset = offset_of_midpoint(batch, 0, batch.first_count - 1, box);
  const std::array<float, 3> other_offset = offset_of_midpoint(batch, others, batch.count - 1, box);
  Lowest lowest;
  Lowest lowest_of_others;
  for (std::size_t first = 0; first < leaves.count; first += hn::Lanes(Wide())) {
    const WideVec value = hn::LoadU(Wide(), leaves.value.data() + first);
    lowest.update(bounds_at(leaves, first, value, offset), first);
    lowest_of_others.update(bounds_at(leaves, first, value, other_offset), first);
  }
  const auto [nearest, second] = lowest.two_indices();
  const std::size_t of_others = lowest_of_others.index();
  return {leaf_at(bvh, leaves.child[nearest]), leaf_at(bvh, leaves.child[of_others == nearest ? second : of_others])};
}

/// Lists the leaves whose bound is within the limit of any point; returns how many. The limits are raised by 6 slack S,
/// which covers all rounding (reports/performance/batched_closest_point.md).
HWY_INLINE std::size_t leaves_near_any(const BvhView& bvh, const BoundList& leaves, const QueryBox& box,
                                       const PointLimits& limits, QueryBatch& batch) {
  const Points d;
  const Wide w;
  const hn::RebindToSigned<Wide> wi;
  alignas(64) std::array<PointLanes, 3> offset;
  alignas(64) PointLanes most;
  for (std::size_t first = 0; first < QueryBatch::capacity; first += hn::Lanes(d)) {
    PointVec squared_offset = hn::Zero(d);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const PointVec part = hn::Sub(load_points(batch.at[axis].data() + first), hn::Set(d, box.middle[axis]));
      hn::Store(part, d, offset[axis].data() + first);
      squared_offset = hn::MulAdd(part, part, squared_offset);
    }
    const PointVec limit = load_points(limits.limit.data() + first);
    const PointVec sizes = hn::Add(hn::Sqrt(hn::Max(limit, hn::Zero(d))), hn::Sqrt(squared_offset));
    const PointVec rounding = hn::Mul(hn::Set(d, 6 * bvh.slack), hn::Add(sizes, hn::Set(d, bvh.slack)));
    hn::Store(hn::Add(hn::Sub(limit, squared_offset), rounding), d, most.data() + first);
  }
  std::size_t count = 0;
  for (std::size_t start = 0; start < leaves.count; start += hn::Lanes(w)) {
    const WideVec value = hn::LoadU(w, leaves.value.data() + start);
    const WideVec x = hn::LoadU(w, leaves.slope[0].data() + start);
    const WideVec y = hn::LoadU(w, leaves.slope[1].data() + start);
    const WideVec z = hn::LoadU(w, leaves.slope[2].data() + start);
    WideVec highest = hn::Set(w, -far_away);  // of the limits of all points: a leaf above it is culled
    for (std::size_t n = 0; n < batch.count; ++n) {
      highest = hn::Max(highest,
                        hn::NegMulAdd(z, hn::Set(w, offset[2][n]),
                                      hn::NegMulAdd(y, hn::Set(w, offset[1][n]),
                                                    hn::NegMulAdd(x, hn::Set(w, offset[0][n]), hn::Set(w, most[n])))));
    }
    const auto kept = hn::RebindMask(wi, hn::Le(value, highest));
    hn::StoreU(hn::Compress(hn::LoadU(wi, leaves.child.data() + start), kept), wi, batch.near.data() + count);
    count += hn::CountTrue(wi, kept);
  }
  return count;
}

/// Squared distances of points, one a lane, to the oriented box of one child.
HWY_INLINE PointVec squared_to_box(const BvhNode& node, std::size_t child_lane, const Vec3Of<PointVec>& point) {
  const Points d;
  const auto one = [&](const std::array<BvhLanes, 3>& lanes) HWY_ATTR {
    return Vec3Of<PointVec>{hn::Set(d, lanes[0][child_lane]), hn::Set(d, lanes[1][child_lane]),
                            hn::Set(d, lanes[2][child_lane])};
  };
  const auto beyond = [&](PointVec at, const BvhLanes& lower, const BvhLanes& upper) HWY_ATTR {
    const PointVec out =
        hn::Max(hn::Sub(hn::Set(d, lower[child_lane]), at), hn::Sub(at, hn::Set(d, upper[child_lane])));
    return hn::Max(out, hn::Zero(d));
  };
  const Vec3Of<PointVec> normal = one(node.normal);
  const Vec3Of<PointVec> tangent = one(node.tangent);
  const Vec3Of<PointVec> out{beyond(dot(normal, point), node.obb_lower[0], node.obb_upper[0]),
                             beyond(dot(tangent, point), node.obb_lower[1], node.obb_upper[1]),
                             beyond(dot(cross(normal, tangent), point), node.obb_lower[2], node.obb_upper[2])};
  return dot(out, out);
}

HWY_INLINE void add_pairs_of_all_points(std::int32_t leaf, QueryBatch& batch) {
  for (std::size_t n = 0; n < batch.count; ++n) {
    batch.leaf[batch.pairs] = leaf;
    batch.point[batch.pairs++] = static_cast<std::int32_t>(n);
  }
}

/// Adds the pairs of the leaves listed as near whose oriented box is within the limit of a point, except the `known`
/// leaves.
HWY_INLINE void add_pairs_within_limits(const BvhView& bvh, std::span<const std::int32_t> near,
                                        const std::array<std::int32_t, 2>& known, const PointLimits& limits,
                                        QueryBatch& batch) {
  const Points d;
  const hn::RebindToSigned<Points> di;
  std::size_t pairs = batch.pairs;
  std::int32_t* HWY_RESTRICT points_of = batch.point.data();
  std::int32_t* HWY_RESTRICT leaf_of = batch.leaf.data();
  for (const std::int32_t entry : near) {
    const auto child = static_cast<std::size_t>(entry);
    const BvhNode& node = bvh.nodes[child / bvh_width];
    const std::int32_t leaf = ~node.child[child % bvh_width];
    if (leaf == known[0] || leaf == known[1]) {
      continue;
    }
    for (std::size_t first = 0; first < QueryBatch::capacity; first += hn::Lanes(d)) {
      const Vec3Of<PointVec> at{load_points(batch.at[0].data() + first), load_points(batch.at[1].data() + first),
                                load_points(batch.at[2].data() + first)};
      const PointVec squared = squared_to_box(node, child % bvh_width, at);
      const auto kept = hn::RebindMask(di, hn::Le(squared, load_points(limits.limit.data() + first)));
      const auto points = hn::Iota(di, static_cast<std::int32_t>(first));
      hn::StoreU(hn::Compress(points, kept), di, points_of + pairs);
      hn::StoreU(hn::Set(di, leaf), di, leaf_of + pairs);
      pairs += hn::CountTrue(di, kept);
    }
    prefetch(bvh.leaves[leaf]);
  }
  batch.pairs = pairs;
}

HWY_INLINE void add_candidates(const BvhView& bvh, const PointLimits& limits, const QueryBatch& batch,
                               CandidateTriangles& candidates) {
  const Lanes d;
  const IntLanes di;
  candidates.make_room(bvh_width * (batch.pairs + 1));
  std::int32_t* HWY_RESTRICT triangle_of = candidates.triangle.data();
  std::int32_t* HWY_RESTRICT point_of = candidates.point.data();
  std::size_t count = candidates.count;
  for (std::size_t pair = 0; pair < batch.pairs; ++pair) {
    const BvhLeaf& leaf = bvh.leaves[batch.leaf[pair]];
    const auto n = static_cast<std::size_t>(batch.point[pair]);
    const Vec limit = hn::Set(d, limits.limit[n]);
    for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
      const auto near = hn::RebindMask(di, hn::Le(load(batch.squared[pair].to, first), limit));
      hn::StoreU(hn::Compress(hn::Load(di, leaf.triangle.data() + first), near), di, triangle_of + count);
      hn::StoreU(hn::Set(di, batch.number[n]), di, point_of + count);
      count += hn::CountTrue(di, near);
    }
  }
  candidates.count = count;
}

}  // namespace

void candidate_triangles_of(const BvhView& bvh, const BoundList& leaves, const QueryBox& box, QueryBatch& batch,
                            CandidateTriangles& candidates) {
  if (leaves.count == 0) {
    return;
  }
  // Each step for all points, so that their latencies overlap.
  batch.make_room(leaves.count);
  PointLimits limits;
  start(bvh, box, batch, limits);
  const std::array<std::int32_t, 2> nearest = nearest_leaves(bvh, leaves, box, batch);
  batch.pairs = 0;
  for (std::size_t l = 0; l < (nearest[0] == nearest[1] ? 1 : 2); ++l) {
    add_pairs_of_all_points(nearest[l], batch);
  }
  measure_pairs(bvh, 0, batch, limits);
  // Some leaves at a time: what these tell of the distances leaves fewer pairs with the next ones.
  constexpr std::size_t at_a_time = 16;
  lower_limits(bvh.slack, 0, limits);
  const std::size_t near = leaves_near_any(bvh, leaves, box, limits, batch);
  for (std::size_t first = 0; first < near; first += at_a_time) {
    if (first > 0) lower_limits(bvh.slack, 0, limits);
    const std::size_t known_pairs = batch.pairs;
    add_pairs_within_limits(bvh, std::span(batch.near).subspan(first, std::min(at_a_time, near - first)), nearest,
                            limits, batch);
    measure_pairs(bvh, known_pairs, batch, limits);
  }
  lower_limits(bvh.near_slack, bvh.slack_growth, limits);  // holds for triangles, not for boxes
  add_candidates(bvh, limits, batch, candidates);
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(candidate_triangles_of);

void QueryBatch::make_room(std::size_t leaves) {
  const std::size_t needed = leaves + BoundList::padding;
  if (needed > near.size()) {
    near.resize(2 * needed);
    leaf.resize(2 * capacity * needed);
    point.resize(2 * capacity * needed);
    squared.resize(2 * capacity * needed);
  }
}

void CandidateTriangles::make_room(std::size_t more) {
  if (count + more > point.size()) {
    point.resize(2 * (count + more));
    triangle.resize(2 * (count + more));
  }
}

void list_candidate_triangles(const BvhView& bvh, const BoundList& leaves, const QueryBox& box, QueryBatch& batch,
                              CandidateTriangles& candidates) {
  HWY_DYNAMIC_DISPATCH(candidate_triangles_of)(bvh, leaves, box, batch, candidates);
}

}  // namespace musclebench
#endif
