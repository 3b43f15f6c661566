#include "backends/sdf/octree/octree_kernel.hpp"

#include <array>
#include <cstddef>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/sdf/octree/octree_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "backends/sdf/grid/field_lanes-inl.hpp"
#include "backends/sdf/octree/octree_entry.hpp"
#include "backends/sdf/octree/octree_polynomial.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

using Entries = hn::Rebind<std::uint32_t, Lanes>;
using Entry = hn::Vec<Entries>;
using Integers = hn::Rebind<std::int32_t, Lanes>;
using Integer = hn::Vec<Integers>;

std::size_t groups_of(const FieldBlock& block) { return (block.count + lane_count - 1) / lane_count; }

HWY_INLINE Vec3Lanes load(const FieldBlock::Lanes<double>& x, const FieldBlock::Lanes<double>& y,
                          const FieldBlock::Lanes<double>& z, std::size_t first) {
  const Lanes d;
  return {hn::Load(d, x.data() + first), hn::Load(d, y.data() + first), hn::Load(d, z.data() + first)};
}

/// The paths of points from their roots to their leaves.
struct Paths {
  /// Coordinates in the root; y and z shifted by one and two bits, so that a level's bits make an octant.
  FieldBlock::Lanes<std::int32_t> x, y, z;
  FieldBlock::Lanes<std::int32_t> levels;
};

HWY_INLINE Vec root_of(Vec at, double roots) { return hn::Min(hn::Floor(at), set(roots - 1)); }

HWY_INLINE void enter_roots(const OctreeView& field, const Vec3Lanes& at, std::size_t first, Paths& paths,
                            LeafBlock& leaves) {
  const Integers integers;
  const Vec3Lanes root{root_of(at.x, field.roots[0]), root_of(at.y, field.roots[1]), root_of(at.z, field.roots[2])};
  const Vec row = add_product(root.y, root.z, set(field.roots[1]));
  const Integer index = hn::DemoteTo(integers, add_product(root.x, row, set(field.roots[0])));
  hn::Store(hn::GatherIndex(Entries(), field.entries, index), Entries(), leaves.entry.data() + first);
  const auto path = [&](Vec along, Vec along_root) HWY_ATTR {
    const Vec share = hn::Mul(hn::Sub(along, along_root), set(1 << octree_most_levels));
    return hn::DemoteTo(integers, hn::Min(share, set((1 << octree_most_levels) - 1)));
  };
  hn::Store(path(at.x, root.x), integers, paths.x.data() + first);
  hn::Store(hn::ShiftLeft<1>(path(at.y, root.y)), integers, paths.y.data() + first);
  hn::Store(hn::ShiftLeft<2>(path(at.z, root.z)), integers, paths.z.data() + first);
  hn::Store(hn::Zero(integers), integers, paths.levels.data() + first);
}

/// Descends to the children of split entries; whether any was split.
HWY_INLINE bool descend(const OctreeView& field, int shift, std::size_t first, Paths& paths, LeafBlock& leaves) {
  const Entries entries;
  const Integers integers;
  const Entry entry = hn::Load(entries, leaves.entry.data() + first);
  const auto is_split = hn::Lt(entry, hn::Set(entries, std::uint32_t{1} << octree_entry::offset_bits));
  if (hn::AllFalse(entries, is_split)) {
    return false;
  }
  const auto bit = [&](const FieldBlock::Lanes<std::int32_t>& path, int of) HWY_ATTR {
    const Integer shifted = hn::ShiftRightSame(hn::Load(integers, path.data() + first), shift);
    return hn::And(shifted, hn::Set(integers, of));
  };
  const Integer octant = hn::Or(hn::Or(bit(paths.x, 1), bit(paths.y, 2)), bit(paths.z, 4));
  const auto split = hn::RebindMask(integers, is_split);
  const Integer child = hn::IfThenElseZero(split, hn::Add(hn::BitCast(integers, entry), octant));
  const Entry next = hn::GatherIndex(entries, field.entries, child);
  hn::Store(hn::IfThenElse(is_split, next, entry), entries, leaves.entry.data() + first);
  const Integer levels = hn::Load(integers, paths.levels.data() + first);
  hn::Store(hn::Sub(levels, hn::VecFromMask(integers, split)), integers, paths.levels.data() + first);
  return true;
}

/// Positions in the leaves, whose coefficients are prefetched.
HWY_INLINE void locate_in_leaves(const OctreeView& field, const Vec3Lanes& at, std::size_t first, const Paths& paths,
                                 LeafBlock& leaves) {
  const Lanes d;
  const Integers integers;
  const Integer levels = hn::Load(integers, paths.levels.data() + first);
  const Vec edges = hn::PromoteTo(d, hn::Shl(hn::Set(integers, 1), levels));
  hn::Store(edges, d, leaves.edges_per_root.data() + first);
  const auto position = [&](Vec along, double roots) HWY_ATTR {
    const Vec in_edges = hn::Mul(hn::Sub(along, root_of(along, roots)), edges);
    const Vec leaf = hn::Min(hn::Floor(in_edges), hn::Sub(edges, set(1)));
    const Vec share = hn::Sub(in_edges, leaf);
    return hn::Sub(hn::Add(share, share), set(1));
  };
  hn::Store(position(at.x, field.roots[0]), d, leaves.x.data() + first);
  hn::Store(position(at.y, field.roots[1]), d, leaves.y.data() + first);
  hn::Store(position(at.z, field.roots[2]), d, leaves.z.data() + first);
  for (std::size_t lane = first; lane < first + lane_count; ++lane) {
    const float* from = field.coefficients + octree_entry::offset_of(leaves.entry[lane]);
    __builtin_prefetch(from);
    __builtin_prefetch(from + cubic_terms - 1);
  }
}

/// All points one level at a time, so that their memory latencies overlap.
void find_leaves(const OctreeView& field, const FieldBlock& block, LeafBlock& leaves) {
  Paths paths;
  const std::size_t end = groups_of(block) * lane_count;
  for (std::size_t first = 0; first < end; first += lane_count) {
    enter_roots(field, load(block.x, block.y, block.z, first), first, paths, leaves);
  }
  bool more = true;
  for (int shift = octree_most_levels - 1; more && shift >= 0; --shift) {
    more = false;
    for (std::size_t first = 0; first < end; first += lane_count) {
      more |= descend(field, shift, first, paths, leaves);
    }
  }
  for (std::size_t first = 0; first < end; first += lane_count) {
    locate_in_leaves(field, load(block.x, block.y, block.z, first), first, paths, leaves);
  }
}

struct Polynomial {
  Vec value;
  Vec3Lanes slope;  ///< over [-1, 1]^3
};

/// As `evaluate_polynomial`.
template <bool cubic>
HWY_INLINE Polynomial evaluate(const Vec* HWY_RESTRICT c, const Vec3Lanes& at) {
  const auto& [x, y, z] = at;
  const auto twice = [](Vec v) HWY_ATTR { return hn::Add(v, v); };
  const auto thrice = [](Vec v) HWY_ATTR { return hn::Mul(set(3), v); };
  Vec a0 = hn::Add(add_product(c[0], y, add_product(add_product(c[2], y, c[7]), z, c[8])),
                   hn::Mul(z, add_product(c[3], z, c[9])));
  Vec a1 = add_product(add_product(c[1], y, c[5]), z, c[6]);
  Vec a2 = c[4];
  Vec b0 = add_product(add_product(c[2], y, twice(c[7])), z, c[8]);
  Vec b1 = c[5];
  Vec d0 = add_product(add_product(c[3], y, c[8]), z, twice(c[9]));
  Vec d1 = c[6];
  if constexpr (!cubic) {
    return {add_product(a0, x, add_product(a1, x, a2)),
            {add_product(a1, x, twice(a2)), add_product(b0, x, b1), add_product(d0, x, d1)}};
  } else {
    const Vec yy = hn::Mul(y, y), zz = hn::Mul(z, z);
    a0 = hn::Add(a0, sum_of_products(yy, sum_of_products(y, c[16], z, c[17]), zz, sum_of_products(y, c[18], z, c[19])));
    a1 = hn::Add(a1, sum_of_products(y, sum_of_products(y, c[13], z, c[14]), zz, c[15]));
    a2 = hn::Add(a2, sum_of_products(y, c[11], z, c[12]));
    b0 = hn::Add(b0, sum_of_products(y, sum_of_products(y, thrice(c[16]), z, twice(c[17])), zz, c[18]));
    b1 = hn::Add(b1, sum_of_products(y, twice(c[13]), z, c[14]));
    d0 = hn::Add(d0, sum_of_products(y, sum_of_products(y, c[17], z, twice(c[18])), zz, thrice(c[19])));
    d1 = hn::Add(d1, sum_of_products(y, c[14], z, twice(c[15])));
    const Vec a3 = c[10];
    return {add_product(a0, x, add_product(a1, x, add_product(a2, x, a3))),
            {add_product(a1, x, add_product(twice(a2), x, thrice(a3))), add_product(b0, x, add_product(b1, x, c[11])),
             add_product(d0, x, add_product(d1, x, c[12]))}};
  }
}

/// A vector's leaves.
struct Leaves {
  std::array<const float*, lane_count> coefficients;
  hn::Mask<Lanes> cubic, outside;
  bool any_cubic = false;
  bool any_outside = false;
};

HWY_INLINE Leaves leaves_at(const OctreeView& field, const LeafBlock& block, std::size_t first) {
  using Kind = octree_entry::Kind;
  const Lanes d;
  const Entries entries;
  const Entry entry = hn::Load(entries, block.entry.data() + first);
  const Vec kind = hn::PromoteTo(d, hn::BitCast(Integers(), hn::ShiftRight<octree_entry::offset_bits>(entry)));
  Leaves leaves;
  leaves.cubic = hn::Eq(kind, set(static_cast<double>(Kind::cubic)));
  leaves.outside = hn::Eq(kind, set(static_cast<double>(Kind::outside)));
  leaves.any_cubic = !hn::AllFalse(d, leaves.cubic);
  leaves.any_outside = !hn::AllFalse(d, leaves.outside);
  for (std::size_t lane = 0; lane < lane_count; ++lane) {
    leaves.coefficients[lane] = field.coefficients + octree_entry::offset_of(block.entry[first + lane]);
  }
  return leaves;
}

/// The first so many coefficients, whole vectors of them, side by side.
template <std::size_t terms>
HWY_INLINE void load_terms(const Leaves& leaves, std::size_t from, Vec* HWY_RESTRICT c) {
  for (std::size_t n = from; n < terms; n += lane_count) {
    const auto row = [&](std::size_t lane) HWY_ATTR { return load_wide(leaves.coefficients[lane] + n); };
    transpose(Lanes(), row, c + n);
  }
}

/// The coefficients of a vector's polynomials, those of degree 3 only where any has them; of leaves outside constants.
HWY_INLINE void load_leaf(const Leaves& leaves, Vec* HWY_RESTRICT c) {
  constexpr std::size_t whole_quadratic = (quadratic_terms + lane_count - 1) / lane_count * lane_count;
  load_terms<whole_quadratic>(leaves, 0, c);
  if (leaves.any_outside) {
    for (std::size_t term = 1; term < quadratic_terms; ++term) {
      c[term] = hn::IfThenZeroElse(leaves.outside, c[term]);
    }
  }
  if (leaves.any_cubic) {
    load_terms<cubic_terms>(leaves, whole_quadratic, c);
    for (std::size_t term = quadratic_terms; term < cubic_terms; ++term) {
      c[term] = hn::IfThenElseZero(leaves.cubic, c[term]);
    }
  }
}

HWY_INLINE Polynomial evaluate_lanes(const Leaves& leaves, const Vec3Lanes& at) {
  Vec c[cubic_terms];
  load_leaf(leaves, c);
  return leaves.any_cubic ? evaluate<true>(c, at) : evaluate<false>(c, at);
}

HWY_INLINE Vec length(const Vec3Lanes& v) {
  return hn::Sqrt(hn::Add(sum_of_products(v.x, v.x, v.y, v.y), hn::Mul(v.z, v.z)));
}

/// A leaf outside: the distance at its centre less the distance to the centre, because it is 1-Lipschitz.
HWY_INLINE void descend_from_middle(const Leaves& leaves, const Vec3Lanes& at, Vec half_edge_m, Vec& value_m,
                                    Vec3Lanes& slope) {
  const Vec from_centre = length(at);
  value_m = hn::IfThenElse(leaves.outside, hn::Sub(value_m, hn::Mul(half_edge_m, from_centre)), value_m);
  const auto inwards = [&](Vec along) HWY_ATTR {
    const Vec share = hn::Div(along, from_centre);
    return hn::Sub(set(0), hn::IfThenElseZero(hn::Gt(from_centre, set(0)), share));
  };
  slope = {hn::IfThenElse(leaves.outside, inwards(at.x), slope.x),
           hn::IfThenElse(leaves.outside, inwards(at.y), slope.y),
           hn::IfThenElse(leaves.outside, inwards(at.z), slope.z)};
}

void evaluate_all(const OctreeView& field, FieldBlock& block, LeafBlock& block_leaves) {
  const Lanes d;
  find_leaves(field, block, block_leaves);
  for (std::size_t first = 0; first < block.count; first += lane_count) {
    const Leaves leaves = leaves_at(field, block_leaves, first);
    const Vec3Lanes at = load(block_leaves.x, block_leaves.y, block_leaves.z, first);
    const Vec edges = hn::Load(d, block_leaves.edges_per_root.data() + first);
    const Polynomial found = evaluate_lanes(leaves, at);
    const Vec per_m = hn::Mul(edges, set(2 / field.root_edge_m));
    Vec value_m = found.value;
    Vec3Lanes slope{hn::Mul(found.slope.x, per_m), hn::Mul(found.slope.y, per_m), hn::Mul(found.slope.z, per_m)};
    if (leaves.any_outside) {
      descend_from_middle(leaves, at, hn::Div(set(0.5 * field.root_edge_m), edges), value_m, slope);
    }
    // A polynomial that is computed as a cubic one may have the other zero.
    const auto store = [&](Vec v, FieldBlock::Lanes<double>& to)
                           HWY_ATTR { hn::Store(hn::Add(v, set(0)), d, to.data() + first); };
    store(value_m, block.value_m);
    store(slope.x, block.slope_x);
    store(slope.y, block.slope_y);
    store(slope.z, block.slope_z);
  }
}

/// Two half edges out along the gradient, but in the field.
HWY_INLINE Vec3Lanes farther_out(const OctreeView& field, const FieldBlock& block, const LeafBlock& leaves,
                                 std::size_t first) {
  const Vec3Lanes at = load(block.x, block.y, block.z, first);
  const Vec3Lanes slope = load(block.slope_x, block.slope_y, block.slope_z, first);
  const Vec steepness = hn::Mul(length(slope), hn::Load(Lanes(), leaves.edges_per_root.data() + first));
  const auto step = [&](Vec along, Vec slope_along, double roots) HWY_ATTR {
    const Vec offset = hn::IfThenElseZero(hn::Gt(steepness, set(0)), hn::Div(slope_along, steepness));
    return hn::Min(hn::Max(hn::Add(along, offset), set(0)), set(roots));
  };
  return {step(at.x, slope.x, field.roots[0]), step(at.y, slope.y, field.roots[1]),
          step(at.z, slope.z, field.roots[2])};
}

/// A lower bound of the exact distance at the points of a vector (reports/performance/field_bounds.md, "Clearance from
/// a sample farther out"): the distance of that sample less the distance to it. `beyond` are points farther out.
HWY_INLINE Vec distance_at_least(const OctreeView& field, const Vec3Lanes& at, const Vec3Lanes& beyond,
                                 const LeafBlock& leaves_beyond, std::size_t first) {
  const Leaves leaves = leaves_at(field, leaves_beyond, first);
  const Vec3Lanes in_leaf = load(leaves_beyond.x, leaves_beyond.y, leaves_beyond.z, first);
  const auto nearest = [&](Vec along) HWY_ATTR { return hn::IfThenZeroElse(leaves.outside, hn::Round(along)); };
  const Vec3Lanes sampled{nearest(in_leaf.x), nearest(in_leaf.y), nearest(in_leaf.z)};
  const Vec edges = hn::Load(Lanes(), leaves_beyond.edges_per_root.data() + first);
  const Vec half_edge = hn::Div(set(0.5), edges);
  const auto displacement = [&](Vec from, Vec to, Vec to_in_leaf, Vec sample) HWY_ATTR {
    return hn::Sub(add_product(to, half_edge, hn::Sub(sample, to_in_leaf)), from);
  };
  const Vec away =
      length({displacement(at.x, beyond.x, in_leaf.x, sampled.x), displacement(at.y, beyond.y, in_leaf.y, sampled.y),
              displacement(at.z, beyond.z, in_leaf.z, sampled.z)});
  const Vec value_m = evaluate_lanes(leaves, sampled).value;
  const Vec excess_m = hn::IfThenZeroElse(leaves.outside, set(field.excess_m));
  return hn::Sub(hn::Sub(value_m, excess_m), hn::Mul(away, set(field.root_edge_m)));
}

/// Radii around the points of a vector in which their leaves are positive.
HWY_INLINE Vec positive_in_leaf(const OctreeView& field, const Leaves& leaves, const FieldBlock& block,
                                const LeafBlock& block_leaves, std::size_t first) {
  const Lanes d;
  Vec c[cubic_terms];
  load_leaf(leaves, c);
  const auto sum_of_sizes = [&](std::size_t from, std::size_t to) HWY_ATTR {
    Vec sum = hn::Abs(c[from]);
    for (std::size_t term = from + 1; term < to; ++term) {
      sum = hn::Add(sum, hn::Abs(c[term]));
    }
    return sum;
  };
  Vec curvature = hn::Mul(set(2), sum_of_sizes(4, quadratic_terms));
  if (leaves.any_cubic) {
    curvature = add_product(curvature, set(6), sum_of_sizes(quadratic_terms, cubic_terms));
  }
  const Vec half_edge_m =
      hn::Div(set(0.5 * field.root_edge_m), hn::Load(d, block_leaves.edges_per_root.data() + first));
  const Vec value_m = hn::Load(d, block.value_m.data() + first);
  const Vec steepness = hn::Mul(length(load(block.slope_x, block.slope_y, block.slope_z, first)), half_edge_m);
  // v - s r - c r^2 / 2 is positive up to its root.
  const Vec root = hn::Sqrt(add_product(hn::Mul(steepness, steepness), hn::Add(value_m, value_m), curvature));
  const Vec by_slope = hn::Div(hn::Add(value_m, value_m), hn::Add(steepness, root));
  const Vec3Lanes at = load(block_leaves.x, block_leaves.y, block_leaves.z, first);
  const Vec to_face = hn::Sub(set(1), hn::Max(hn::Max(hn::Abs(at.x), hn::Abs(at.y)), hn::Abs(at.z)));
  const Vec radius = hn::IfThenElse(hn::Or(leaves.outside, hn::Gt(by_slope, to_face)), to_face, by_slope);
  return hn::Mul(radius, half_edge_m);
}

/// The points of a block at `indices`.
HWY_INLINE Vec3Lanes gather(const FieldBlock& block, const FieldBlock::Lanes<std::uint64_t>& indices,
                            std::size_t first) {
  const Lanes d;
  const hn::RebindToSigned<Lanes> integers;
  const auto index = hn::BitCast(integers, hn::Load(hn::RebindToUnsigned<Lanes>(), indices.data() + first));
  return {hn::GatherIndex(d, block.x.data(), index), hn::GatherIndex(d, block.y.data(), index),
          hn::GatherIndex(d, block.z.data(), index)};
}

void clear_all(const OctreeView& field, const FieldBlock& block, const LeafBlock& leaves,
               FieldBlock::Lanes<double>& clearance_m) {
  const Lanes d;
  const hn::RebindToUnsigned<Lanes> integers;
  const auto free_m = [&](Vec distance_m) HWY_ATTR { return hn::Sub(distance_m, set(field.sign_error_distance_m)); };
  const auto shrunk = [](Vec radius_m) HWY_ATTR { return hn::Mul(radius_m, set(1 - 1e-9)); };
  // Points for which a sample farther out may give a larger radius than their leaf.
  FieldBlock farther;
  for (std::size_t first = 0; first < block.count; first += lane_count) {
    const Leaves own = leaves_at(field, leaves, first);
    const Vec here_m = free_m(hn::Load(d, block.value_m.data() + first));
    const Vec in_leaf_m = positive_in_leaf(field, own, block, leaves, first);
    const Vec known_m = hn::Max(in_leaf_m, hn::IfThenElseZero(own.outside, here_m));
    hn::Store(shrunk(hn::IfThenElseZero(hn::Gt(known_m, set(0)), known_m)), d, clearance_m.data() + first);
    const auto wanted = hn::And(hn::AndNot(own.outside, hn::Gt(here_m, set(0))),
                                hn::FirstN(d, HWY_MIN(lane_count, block.count - first)));
    if (!hn::AllFalse(d, wanted)) {
      append(farther_out(field, block, leaves, first), hn::Iota(integers, first), wanted, farther);
    }
  }
  if (farther.count == 0) {
    return;
  }
  farther.fill_last_vector();
  LeafBlock leaves_beyond;
  find_leaves(field, farther, leaves_beyond);
  for (std::size_t first = 0; first < farther.count; first += lane_count) {
    const Vec least_m = distance_at_least(field, gather(block, farther.query, first),
                                          load(farther.x, farther.y, farther.z, first), leaves_beyond, first);
    hn::Store(shrunk(free_m(least_m)), d, farther.value_m.data() + first);
  }
  for (std::size_t n = 0; n < farther.count; ++n) {
    double& known_m = clearance_m[farther.query[n]];
    known_m = HWY_MAX(known_m, farther.value_m[n]);
  }
}

}  // namespace

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(evaluate_all);
HWY_EXPORT(clear_all);

void evaluate_block(const OctreeView& field, FieldBlock& block, LeafBlock& leaves) {
  if (block.count > 0) {
    block.fill_last_vector();
    HWY_DYNAMIC_DISPATCH(evaluate_all)(field, block, leaves);
  }
}

void clear_block(const OctreeView& field, const FieldBlock& block, const LeafBlock& leaves,
                 FieldBlock::Lanes<double>& clearance_m) {
  HWY_DYNAMIC_DISPATCH(clear_all)(field, block, leaves, clearance_m);
}

}  // namespace musclebench
#endif
