#include "core/bvh/triangle_bvh_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/prefetch.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/bvh/triangle_bvh_search.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/bvh/triangle_bvh_lanes-inl.hpp"

// How far a distance computed here may be from the true one is derived in reports/performance/bvh_error_bounds.md.
HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

/// Distance outside an interval; 0 within.
HWY_INLINE Vec outside(Vec p, const BvhLanes& lower, const BvhLanes& upper, std::size_t first) {
  const Vec distance = hn::Max(hn::Sub(load(lower, first), p), hn::Sub(p, load(upper, first)));
  return hn::Max(distance, hn::Zero(Lanes()));
}

HWY_INLINE Vec dot(const std::array<BvhLanes, 3>& axis, const Vec3Lanes& p, std::size_t first) {
  return dot(load(axis, first), p);
}

HWY_INLINE Vec squared_length(Vec x, Vec y, Vec z) { return hn::MulAdd(z, z, hn::MulAdd(y, y, hn::Mul(x, x))); }

/// Squared distances to the children: to the AABB or to the OBB, whichever is farther.
HWY_INLINE Vec squared_to_children(const BvhNode& node, const Vec3Lanes& p, std::size_t first) {
  const Vec to_aabb = squared_length(outside(p.x, node.lower[0], node.upper[0], first),
                                     outside(p.y, node.lower[1], node.upper[1], first),
                                     outside(p.z, node.lower[2], node.upper[2], first));
  const Vec nx = load(node.normal[0], first);
  const Vec ny = load(node.normal[1], first);
  const Vec nz = load(node.normal[2], first);
  const Vec tx = load(node.tangent[0], first);
  const Vec ty = load(node.tangent[1], first);
  const Vec tz = load(node.tangent[2], first);
  const Vec third = hn::MulAdd(
      hn::MulSub(nx, ty, hn::Mul(ny, tx)), p.z,
      hn::MulAdd(hn::MulSub(nz, tx, hn::Mul(nx, tz)), p.y, hn::Mul(hn::MulSub(ny, tz, hn::Mul(nz, ty)), p.x)));
  const Vec to_obb = squared_length(outside(dot(node.normal, p, first), node.obb_lower[0], node.obb_upper[0], first),
                                    outside(dot(node.tangent, p, first), node.obb_lower[1], node.obb_upper[1], first),
                                    outside(third, node.obb_lower[2], node.obb_upper[2], first));
  return hn::Max(to_aabb, to_obb);
}

HWY_INLINE Vec squared_to_triangles(const BvhLeaf& leaf, const Vec3Lanes& p, std::size_t first) {
  return arms_to(TriangleLanes::of(leaf, first), p).squared_length();
}

/// Upper bound of the squared distance of the closest triangle as it is computed here, given that of any triangle.
HWY_INLINE float limit_from(float squared, float slack) {
  const float reach = std::sqrt(squared) + 2 * slack;
  return reach * reach * 1.000001F;
}

/// One bit a lane: its squared distance is within the limit.
HWY_INLINE unsigned within(const float* HWY_RESTRICT squared, float limit) {
  const Lanes d;
  unsigned bits = 0;
  for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
    bits |= bits_of(d, hn::Le(hn::Load(d, squared + first), hn::Set(d, limit)), first);
  }
  return bits;
}

HWY_INLINE float least_squared(const BvhLeaf& leaf, const Vec3Lanes& p) {
  const Lanes d;
  Vec least = hn::Set(d, std::numeric_limits<float>::max());
  for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
    least = hn::Min(least, squared_to_triangles(leaf, p, first));
  }
  return hn::GetLane(hn::MinOfLanes(d, least));
}

/// Adds the triangles of a leaf that may be the closest to the candidates and lowers the limit.
HWY_INLINE void collect(const BvhLeaf& leaf, const Vec3Lanes& p, BvhSearch& search) {
  const Lanes d;
  alignas(64) float squared[bvh_width];
  Vec least = hn::Set(d, std::numeric_limits<float>::max());
  for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
    const Vec part = squared_to_triangles(leaf, p, first);
    hn::Store(part, d, squared + first);
    least = hn::Min(least, part);
  }
  unsigned found = within(squared, search.limit);
  if (found == 0) {
    return;
  }
  const float squared_least = hn::GetLane(hn::MinOfLanes(d, least));
  search.least = std::min(search.least, squared_least);
  if (leaf.slivers == 0) {
    const float lowered = limit_from(squared_least, search.slack);
    if (lowered < search.limit) {
      search.limit = lowered;
      found = within(squared, lowered);
    }
  }
  for (; found != 0; found &= found - 1) {
    const auto lane = static_cast<std::size_t>(hwy::Num0BitsBelowLS1Bit_Nonzero32(found));
    search.squared[search.count] = squared[lane];
    search.triangle[search.count] = leaf.triangle[lane];
    prefetch(search.corners[leaf.triangle[lane]]);
    ++search.count;
  }
  if (search.count > BvhSearch::capacity - bvh_width || leaf.slivers != 0) {
    search.decide(search);
  }
}

/// Traverses the tree and calls `visit_leaf(index)` for leaves whose bounds are within `limit`, which `visit_leaf` may
/// lower. The nearest child is visited next, without a round trip through the stack; the others are pushed unsorted,
/// since sorting them costs more than it saves.
template <typename VisitLeaf>
HWY_INLINE void traverse(const BvhSearch& search, const Vec3Lanes& p, const float& limit, VisitLeaf&& visit_leaf) {
  const Lanes d;
  const IntLanes di;
  HWY_ALIGN float squared[bvh_width];
  HWY_ALIGN float near[bvh_stack_capacity];
  HWY_ALIGN std::int32_t child[bvh_stack_capacity];
  int stacked = 0;
  std::int32_t next = 0;
  for (;;) {
    if (next < 0) {
      visit_leaf(~next);
    } else {
      const BvhNode& node = search.nodes[next];
      Vec least = hn::Set(d, std::numeric_limits<float>::max());
      for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
        const Vec part = squared_to_children(node, p, first);
        hn::Store(part, d, squared + first);
        least = hn::Min(least, part);
      }
      const float squared_least = hn::GetLane(hn::MinOfLanes(d, least));
      if (squared_least <= limit) {
        const std::size_t nearest = hwy::Num0BitsBelowLS1Bit_Nonzero32(within(squared, squared_least));
        next = node.child[nearest];
        const auto lane_of_next = hn::Set(di, static_cast<std::int32_t>(nearest));
        for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
          const Vec part = hn::Load(d, squared + first);
          const auto is_other = hn::Ne(hn::Iota(di, static_cast<std::int32_t>(first)), lane_of_next);
          const auto pushed = hn::And(hn::RebindMask(d, is_other), hn::Le(part, hn::Set(d, limit)));
          const auto children = hn::Load(di, node.child.data() + first);
          hn::StoreU(hn::Compress(part, pushed), d, near + stacked);
          hn::StoreU(hn::Compress(children, hn::RebindMask(di, pushed)), di, child + stacked);
          stacked += static_cast<int>(hn::CountTrue(d, pushed));
        }
        if (stacked > 0) {
          const std::int32_t after = child[stacked - 1];
          prefetch_bytes(after < 0 ? static_cast<const void*>(search.leaves + ~after) : search.nodes + after,
                         std::min(sizeof(BvhNode), sizeof(BvhLeaf)));
        }
        continue;
      }
    }
    do {
      if (--stacked < 0) {
        return;
      }
    } while (near[stacked] > limit);
    next = child[stacked];
  }
}

void closest(BvhSearch& search) {
  const Vec3Lanes p = splat(search.point);
  const int first_leaf = search.first_leaf;
  if (first_leaf >= 0) {
    collect(search.leaves[first_leaf], p, search);
  }
  traverse(search, p, search.limit, [&](std::int32_t leaf) HWY_ATTR {
    if (leaf != first_leaf) {
      collect(search.leaves[leaf], p, search);
    }
  });
}

NearestLeaves leaves_within(const BvhSearch& search) {
  constexpr std::size_t capacity = CandidateLeaves::capacity;
  const Vec3Lanes p = splat(search.point);
  NearestLeaves near;
  near.cutoff = search.limit;
  traverse(search, p, near.cutoff, [&](std::int32_t index) HWY_ATTR {
    const float squared = least_squared(search.leaves[index], p);
    if (squared > near.cutoff) {
      return;
    }
    if (near.count == capacity) {
      near.cutoff = std::min(near.cutoff, std::max(squared, near.squared[capacity - 1]));
      if (squared >= near.squared[capacity - 1]) {
        return;
      }
    }
    std::size_t i = near.count < capacity ? near.count++ : capacity - 1;
    for (; i > 0 && near.squared[i - 1] > squared; --i) {
      near.squared[i] = near.squared[i - 1];
      near.leaf[i] = near.leaf[i - 1];
    }
    near.squared[i] = squared;
    near.leaf[i] = index;
  });
  return near;
}

DistanceBound bound(const BvhSearch& search, float squared_fraction) {
  const Vec3Lanes p = splat(search.point);
  std::int32_t nearest = search.first_leaf;
  float least = least_squared(search.leaves[nearest], p);
  float limit = squared_fraction * least;
  traverse(search, p, limit, [&](std::int32_t index) HWY_ATTR {
    const float squared = least_squared(search.leaves[index], p);
    if (squared < least) {
      least = squared;
      limit = squared_fraction * squared;
      nearest = index;
    }
  });
  const BvhLeaf& leaf = search.leaves[nearest];
  HWY_ALIGN float squared[bvh_width];
  for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(Lanes())) {
    hn::Store(squared_to_triangles(leaf, p, first), Lanes(), squared + first);
  }
  const unsigned found = within(squared, least);
  return {limit, leaf.triangle[found == 0 ? 0 : hwy::Num0BitsBelowLS1Bit_Nonzero32(found)]};
}

/// Lower bound of the distance from the query point to the i-th listed leaf, by the triangle inequality.
HWY_INLINE float leaf_distance(const CandidateLeaves& list, std::size_t i, float moved) {
  return static_cast<float>(list.distance[i]) * (list.cutoff * ((1 - 1e-6F) / CandidateLeaves::distance_steps)) - moved;
}

/// With slivers no computed distance is an upper bound, so that candidates have to be decided leaf by leaf.
void listed_leaf_by_leaf(BvhSearch& search, const CandidateLeaves& list, float moved) {
  const Vec3Lanes p = splat(search.point);
  for (std::size_t i = 0; i < CandidateLeaves::capacity && list.leaf[i] >= 0; ++i) {
    const float distance = leaf_distance(list, i, moved);
    if (distance > 0 && distance * distance > search.limit) {
      return;
    }
    collect(search.leaves[list.leaf[i]], p, search);
  }
}

/// Computes all distances before it picks candidates: a mispredicted branch costs as much as half a leaf.
void listed(BvhSearch& search, const CandidateLeaves& list, float moved) {
  const Lanes d;
  const Vec3Lanes p = splat(search.point);
  HWY_ALIGN float squared[CandidateLeaves::capacity * bvh_width];
  const float moved_and_slack = moved + 2 * search.slack;
  float least = bvh_far_away * bvh_far_away;
  std::size_t nearest = 0;
  std::size_t visited = 0;
  for (; visited < CandidateLeaves::capacity && list.leaf[visited] >= 0; ++visited) {
    const float distance = leaf_distance(list, visited, moved_and_slack);
    if (distance > 0 && distance * distance > 1.000001F * least) {
      break;
    }
    const BvhLeaf& leaf = search.leaves[list.leaf[visited]];
    Vec least_here = hn::Set(d, std::numeric_limits<float>::max());
    for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
      const Vec part = squared_to_triangles(leaf, p, first);
      hn::Store(part, d, squared + visited * bvh_width + first);
      least_here = hn::Min(least_here, part);
    }
    const float here = hn::GetLane(hn::MinOfLanes(d, least_here));
    nearest = here < least ? visited : nearest;
    least = std::min(least, here);
  }
  if (search.leaves[list.leaf[nearest]].slivers != 0) {
    listed_leaf_by_leaf(search, list, moved);
    return;
  }
  search.least = least;
  search.limit = std::min(search.limit, limit_from(least, search.slack));
  std::uint64_t found = 0;
  for (std::size_t i = 0; i < visited; ++i) {
    found |= static_cast<std::uint64_t>(within(squared + i * bvh_width, search.limit)) << i * bvh_width;
  }
  for (; found != 0; found &= found - 1) {
    const auto slot = hwy::Num0BitsBelowLS1Bit_Nonzero64(found);
    const std::int32_t triangle = search.leaves[list.leaf[slot / bvh_width]].triangle[slot % bvh_width];
    search.squared[search.count] = squared[slot];
    search.triangle[search.count] = triangle;
    prefetch(search.corners[triangle]);
    ++search.count;
  }
}

}  // namespace
}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(closest);
HWY_EXPORT(leaves_within);
HWY_EXPORT(bound);
HWY_EXPORT(listed);

void search_closest(BvhSearch& search) { HWY_DYNAMIC_DISPATCH(closest)(search); }

NearestLeaves search_leaves(const BvhSearch& search) { return HWY_DYNAMIC_DISPATCH(leaves_within)(search); }

DistanceBound search_bound(const BvhSearch& search, float squared_fraction) {
  return HWY_DYNAMIC_DISPATCH(bound)(search, squared_fraction);
}

void search_listed(BvhSearch& search, const CandidateLeaves& list, float moved) {
  HWY_DYNAMIC_DISPATCH(listed)(search, list, moved);
}

}  // namespace musclebench
#endif
