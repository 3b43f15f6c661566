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

// How far a float distance may be from the truth (u = 2^-24, R = 1 + largest coordinate of the point, E = longest side
// of the mesh; the mesh fits in -1 .. 1, so that an arm from a triangle to the point is at most sqrt(3) R long):
// - the point, the origin and their difference: sqrt(3) u (R - 1) + sqrt(3) u + sqrt(3) u R           <=  3.5 u R
// - the coordinates X, Y (4 u of the arm: rounded axis and sum) and Z (9 u, the axis is a product)    <= 18.5 u R
//   The distance is a 1-Lipschitz function of (X, Y, Z), whichever part of the triangle is nearest.
// - rounded sides of the triangle: u E, twice                                                         <=  3.5 u E
// - evaluation: the place along the slanted side 3 sqrt(3) u R + 4 u E, the two differences 7 u R, the side of the
//   slanted side that the point is on 7 u R + 4 u E, the squares 2.6 u R                              <=   22 u R + 8 u
//   E
// The sum is below 48 u R + 16 u E, which is the slack that TriangleBvh uses. A distance to a box errs less.
// Near a triangle it is far less: only the places themselves, 1.8 u R, are rounded by their coordinates, all else by
// the arm A, 26 u A, or by E, 16 u E. From a triangle at distance D an arm is at most D + E: 1.8 u R + 42 u E + 26 u D
// in all. This does not hold for boxes. Fused or not, each product errs no more than assumed.
HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

/// Each level of the deepest tree leaves up to 7 nodes, and what is written beyond the last one has room, too.
constexpr int stack_capacity = 320;

HWY_INLINE Vec beyond(Vec p, const BvhLanes& lower, const BvhLanes& upper, std::size_t first) {
  const Vec out = hn::Max(hn::Sub(load(lower, first), p), hn::Sub(p, load(upper, first)));
  return hn::Max(out, hn::Zero(Lanes()));
}

HWY_INLINE Vec dot(const std::array<BvhLanes, 3>& axis, const Vec3Lanes& p, std::size_t first) {
  return dot(load(axis, first), p);
}

HWY_INLINE Vec squared_length(Vec x, Vec y, Vec z) { return hn::MulAdd(z, z, hn::MulAdd(y, y, hn::Mul(x, x))); }

/// Squared distances to what bounds the children.
HWY_INLINE Vec squared_to_children(const BvhNode& node, const Vec3Lanes& p, std::size_t first) {
  const Vec to_box =
      squared_length(beyond(p.x, node.lower[0], node.upper[0], first), beyond(p.y, node.lower[1], node.upper[1], first),
                     beyond(p.z, node.lower[2], node.upper[2], first));
  const Vec nx = load(node.normal[0], first);
  const Vec ny = load(node.normal[1], first);
  const Vec nz = load(node.normal[2], first);
  const Vec tx = load(node.tangent[0], first);
  const Vec ty = load(node.tangent[1], first);
  const Vec tz = load(node.tangent[2], first);
  const Vec third = hn::MulAdd(
      hn::MulSub(nx, ty, hn::Mul(ny, tx)), p.z,
      hn::MulAdd(hn::MulSub(nz, tx, hn::Mul(nx, tz)), p.y, hn::Mul(hn::MulSub(ny, tz, hn::Mul(nz, ty)), p.x)));
  const Vec to_turned_box =
      squared_length(beyond(dot(node.normal, p, first), node.slab_lower, node.slab_upper, first),
                     beyond(dot(node.tangent, p, first), node.side_lower[0], node.side_upper[0], first),
                     beyond(third, node.side_lower[1], node.side_upper[1], first));
  return hn::Max(to_box, to_turned_box);
}

HWY_INLINE Vec squared_to_triangles(const BvhLeaf& leaf, const Vec3Lanes& p, std::size_t first) {
  return arms_to(TriangleLanes::of(leaf, first), p).squared_length();
}

/// Square of a distance that the closest triangle does not exceed in floats, given that of another triangle.
HWY_INLINE float limit_from(float squared, float slack) {
  const float reach = std::sqrt(squared) + 2 * slack;
  return reach * reach * 1.000001F;
}

/// A bit a place of a leaf, those within the limit; the squared distances go to `squared`.
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

/// Lists the triangles of a leaf that may be the closest and lowers the limit.
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
    const auto place = static_cast<std::size_t>(hwy::Num0BitsBelowLS1Bit_Nonzero32(found));
    search.squared[search.count] = squared[place];
    search.triangle[search.count] = leaf.triangle[place];
    prefetch(search.corners[leaf.triangle[place]]);
    ++search.count;
  }
  if (search.count > BvhSearch::capacity - bvh_width || leaf.slivers != 0) {
    search.decide(search);
  }
}

/// Calls `look(index)` for leaves whose bounds are within `limit`, which `look` may lower. Of a node's children the
/// nearest one is next, without a way through memory; the others wait on the stack in any order, since sorting them
/// costs more than it saves.
template <typename Look>
HWY_INLINE void walk(const BvhSearch& search, const Vec3Lanes& p, const float& limit, Look&& look) {
  const Lanes d;
  const IntLanes di;
  HWY_ALIGN float squared[bvh_width];
  HWY_ALIGN float near[stack_capacity];
  HWY_ALIGN std::int32_t child[stack_capacity];
  int waiting = 0;
  std::int32_t next = 0;
  for (;;) {
    if (next < 0) {
      look(~next);
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
        const auto place_of_next = hn::Set(di, static_cast<std::int32_t>(nearest));
        for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
          const Vec part = hn::Load(d, squared + first);
          const auto is_other = hn::Ne(hn::Iota(di, static_cast<std::int32_t>(first)), place_of_next);
          const auto waits = hn::And(hn::RebindMask(d, is_other), hn::Le(part, hn::Set(d, limit)));
          const auto children = hn::Load(di, node.child.data() + first);
          hn::StoreU(hn::Compress(part, waits), d, near + waiting);
          hn::StoreU(hn::Compress(children, hn::RebindMask(di, waits)), di, child + waiting);
          waiting += static_cast<int>(hn::CountTrue(d, waits));
        }
        if (waiting > 0) {
          const std::int32_t after = child[waiting - 1];
          prefetch_bytes(after < 0 ? static_cast<const void*>(search.leaves + ~after) : search.nodes + after,
                         std::min(sizeof(BvhNode), sizeof(BvhLeaf)));
        }
        continue;
      }
    }
    do {
      if (--waiting < 0) {
        return;
      }
    } while (near[waiting] > limit);
    next = child[waiting];
  }
}

void closest(BvhSearch& search) {
  const Vec3Lanes p = splat(search.point);
  const int first_leaf = search.first_leaf;
  if (first_leaf >= 0) {
    collect(search.leaves[first_leaf], p, search);
  }
  walk(search, p, search.limit, [&](std::int32_t leaf) HWY_ATTR {
    if (leaf != first_leaf) {
      collect(search.leaves[leaf], p, search);
    }
  });
}

NearestLeaves leaves_within(const BvhSearch& search) {
  constexpr std::size_t capacity = CandidateLeaves::capacity;
  const Vec3Lanes p = splat(search.point);
  NearestLeaves near;
  near.others = search.limit;
  walk(search, p, near.others, [&](std::int32_t index) HWY_ATTR {
    const float squared = least_squared(search.leaves[index], p);
    if (squared > near.others) {
      return;
    }
    if (near.count == capacity) {
      near.others = std::min(near.others, std::max(squared, near.squared[capacity - 1]));
      if (squared >= near.squared[capacity - 1]) {
        return;
      }
    }
    std::size_t at = near.count < capacity ? near.count++ : capacity - 1;
    for (; at > 0 && near.squared[at - 1] > squared; --at) {
      near.squared[at] = near.squared[at - 1];
      near.leaf[at] = near.leaf[at - 1];
    }
    near.squared[at] = squared;
    near.leaf[at] = index;
  });
  return near;
}

DistanceBound bound(const BvhSearch& search, float share) {
  const Vec3Lanes p = splat(search.point);
  std::int32_t nearest = search.first_leaf;
  float least = least_squared(search.leaves[nearest], p);
  float limit = share * least;
  walk(search, p, limit, [&](std::int32_t index) HWY_ATTR {
    const float squared = least_squared(search.leaves[index], p);
    if (squared < least) {
      least = squared;
      limit = share * squared;
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

/// At least that far from `search.point` is what is listed at `place`.
HWY_INLINE float least_listed(const CandidateLeaves& list, std::size_t place, float moved) {
  return static_cast<float>(list.distance[place]) * (list.complete * ((1 - 1e-6F) / CandidateLeaves::steps)) - moved;
}

/// For lists with slivers.
void in_listed_leaves_in_turn(BvhSearch& search, const CandidateLeaves& list, float moved) {
  const Vec3Lanes p = splat(search.point);
  for (std::size_t i = 0; i < CandidateLeaves::capacity && list.leaf[i] >= 0; ++i) {
    const float least = least_listed(list, i, moved);
    if (least > 0 && least * least > search.limit) {
      return;
    }
    collect(search.leaves[list.leaf[i]], p, search);
  }
}

/// First all distances, then what may be the closest: a branch that is guessed wrong costs as much as half a leaf.
void in_listed_leaves(BvhSearch& search, const CandidateLeaves& list, float moved) {
  const Lanes d;
  const Vec3Lanes p = splat(search.point);
  HWY_ALIGN float squared[CandidateLeaves::capacity * bvh_width];
  const float certain = moved + 2 * search.slack;
  float least = bvh_far_away * bvh_far_away;
  std::size_t nearest = 0;
  std::size_t looked_at = 0;
  for (; looked_at < CandidateLeaves::capacity && list.leaf[looked_at] >= 0; ++looked_at) {
    const float beyond = least_listed(list, looked_at, certain);
    if (beyond > 0 && beyond * beyond > 1.000001F * least) {
      break;
    }
    const BvhLeaf& leaf = search.leaves[list.leaf[looked_at]];
    Vec least_here = hn::Set(d, std::numeric_limits<float>::max());
    for (std::size_t first = 0; first < bvh_width; first += hn::Lanes(d)) {
      const Vec part = squared_to_triangles(leaf, p, first);
      hn::Store(part, d, squared + looked_at * bvh_width + first);
      least_here = hn::Min(least_here, part);
    }
    const float here = hn::GetLane(hn::MinOfLanes(d, least_here));
    nearest = here < least ? looked_at : nearest;
    least = std::min(least, here);
  }
  if (search.leaves[list.leaf[nearest]].slivers != 0) {
    in_listed_leaves_in_turn(search, list, moved);
    return;
  }
  search.least = least;
  search.limit = std::min(search.limit, limit_from(least, search.slack));
  std::uint64_t found = 0;
  for (std::size_t i = 0; i < looked_at; ++i) {
    found |= static_cast<std::uint64_t>(within(squared + i * bvh_width, search.limit)) << i * bvh_width;
  }
  for (; found != 0; found &= found - 1) {
    const auto place = hwy::Num0BitsBelowLS1Bit_Nonzero64(found);
    const std::int32_t triangle = search.leaves[list.leaf[place / bvh_width]].triangle[place % bvh_width];
    search.squared[search.count] = squared[place];
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
HWY_EXPORT(in_listed_leaves);

void search_closest(BvhSearch& search) { HWY_DYNAMIC_DISPATCH(closest)(search); }

NearestLeaves search_leaves(const BvhSearch& search) { return HWY_DYNAMIC_DISPATCH(leaves_within)(search); }

DistanceBound search_bound(const BvhSearch& search, float share) { return HWY_DYNAMIC_DISPATCH(bound)(search, share); }

void search_listed(BvhSearch& search, const CandidateLeaves& list, float moved) {
  HWY_DYNAMIC_DISPATCH(in_listed_leaves)(search, list, moved);
}

}  // namespace musclebench
#endif
