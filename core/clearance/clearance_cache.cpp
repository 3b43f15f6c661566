#include "core/clearance/clearance_cache.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <limits>
#include <span>

#include "core/base/prefetch.hpp"
#include "core/mesh/mesh_size.hpp"

// Highway compiles this file once for every SIMD target; highway.h has to be included after foreach_target.h.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/clearance/clearance_cache.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#ifndef MUSCLEBENCH_CLEARANCE_CACHE_ONCE
#define MUSCLEBENCH_CLEARANCE_CACHE_ONCE
namespace musclebench {

/// At most 256 bits: a sweep is a short burst between milliseconds of scalar code, in which powering up the 512-bit
/// units costs more than they save.
constexpr std::size_t sweep_lanes = 8;
/// Nodes that are tested together; their positions stay in the first-level cache.
constexpr std::size_t block_size = 256;
/// Blocks of eight spheres that are prefetched ahead of their turn.
constexpr std::size_t prefetch_distance = 20;

// Relative rounding errors of single precision, derived in reports/performance/clearance_cache.md.
/// Of a position, and of a bone's offset, per unit of its 1-norm: rounding, rotation, products and sums.
constexpr float sweep_slack = 1.1e-6F;
/// Of a sphere's centre, per unit of its 1-norm.
constexpr double centre_slack = 2.5e-7;
/// Of a radius and of the comparison of squared lengths.
constexpr double comparison_slack = 2e-6;

constexpr std::size_t padded(std::size_t nodes) { return (nodes + sweep_lanes - 1) / sweep_lanes * sweep_lanes; }

static_assert(sweep_lanes == ClearanceCache::SafeSphereBlock::width && block_size % sweep_lanes == 0);

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Positions relative to the sweep's origin as a structure of arrays, and their rounding errors. Unqueried nodes get
/// position 0 and slack -inf, so that the in-sphere test always holds.
struct alignas(64) Block {
  std::array<float, 3 * block_size> rows;  ///< xyz of node after node, before the transposition
  std::array<float, block_size> x, y, z, slack;
};

/// `is_queried`: by node, 0 or -1.
HWY_INLINE void load_block(const double* HWY_RESTRICT positions, std::size_t count,
                           const std::array<double, 3>& origin_m, const int* HWY_RESTRICT is_queried, Block& block) {
  const hn::CappedTag<double, sweep_lanes / 2> wide;
  const hn::Rebind<float, decltype(wide)> narrow;
  const std::size_t step = hn::Lanes(wide);
  alignas(64) std::array<double, 3 + sweep_lanes / 2> repeated;
  for (std::size_t i = 0; i < repeated.size(); ++i) {
    repeated[i] = origin_m[i % 3];
  }
  const auto narrow_and_store = [&](std::size_t i, auto origin) HWY_ATTR {
    hn::StoreU(hn::DemoteTo(narrow, hn::Sub(hn::LoadU(wide, positions + i), origin)), narrow, block.rows.data() + i);
  };
  const auto origin_0 = hn::LoadU(wide, repeated.data());
  const auto origin_1 = hn::LoadU(wide, repeated.data() + step % 3);
  const auto origin_2 = hn::LoadU(wide, repeated.data() + 2 * step % 3);
  std::size_t i = 0;
  for (; i + 3 * step <= 3 * count; i += 3 * step) {
    narrow_and_store(i, origin_0);
    narrow_and_store(i + step, origin_1);
    narrow_and_store(i + 2 * step, origin_2);
  }
  for (; i < 3 * count; ++i) {
    block.rows[i] = static_cast<float>(positions[i] - origin_m[i % 3]);
  }
  const hn::CappedTag<float, sweep_lanes> lanes;
  const hn::RebindToSigned<decltype(lanes)> ints;
  const auto relative_slack = hn::Set(lanes, sweep_slack);
  const auto never_expired = hn::Set(lanes, -std::numeric_limits<float>::infinity());
  for (std::size_t node = 0; node < count; node += hn::Lanes(lanes)) {
    auto x = relative_slack, y = relative_slack, z = relative_slack;  // overwritten
    hn::LoadInterleaved3(lanes, block.rows.data() + 3 * node, x, y, z);
    const auto slack = hn::Mul(relative_slack, hn::Add(hn::Abs(x), hn::Add(hn::Abs(y), hn::Abs(z))));
    const auto queried = hn::RebindMask(lanes, hn::Lt(hn::LoadU(ints, is_queried + node), hn::Zero(ints)));
    hn::Store(hn::IfThenElseZero(queried, x), lanes, block.x.data() + node);
    hn::Store(hn::IfThenElseZero(queried, y), lanes, block.y.data() + node);
    hn::Store(hn::IfThenElseZero(queried, z), lanes, block.z.data() + node);
    hn::Store(hn::IfThenElse(queried, slack, never_expired), lanes, block.slack.data() + node);
  }
}

/// Appends the nodes from `first` on that have left their safe spheres to the bone's expired ones.
HWY_INLINE void sweep_block(const Block& block, std::size_t first, std::size_t count, ClearanceCache::BoneSweep& bone) {
  const hn::CappedTag<float, sweep_lanes> lanes;
  const hn::RebindToSigned<decltype(lanes)> ints;
  const auto entry = [&](std::size_t row, std::size_t column)
                         HWY_ATTR { return hn::Set(lanes, bone.rotation[row][column]); };
  const auto r00 = entry(0, 0), r01 = entry(0, 1), r02 = entry(0, 2);
  const auto r10 = entry(1, 0), r11 = entry(1, 1), r12 = entry(1, 2);
  const auto r20 = entry(2, 0), r21 = entry(2, 1), r22 = entry(2, 2);
  const auto offset_x = hn::Set(lanes, bone.offset[0]);
  const auto offset_y = hn::Set(lanes, bone.offset[1]);
  const auto offset_z = hn::Set(lanes, bone.offset[2]);
  const auto slack = hn::Set(lanes, bone.slack);
  // Hoisted: hn::Iota from the node's index in every turn would be written in parts and read whole, a store-forwarding
  // stall.
  const auto lane_indices = hn::Iota(ints, 0);
  int* const expired = bone.expired;
  std::size_t found = bone.count;
  for (std::size_t i = 0; i < count; i += hn::Lanes(lanes)) {
    const std::size_t node = first + i;
    const ClearanceCache::SafeSphereBlock& spheres = bone.spheres[node / sweep_lanes];
    const std::size_t lane = node % sweep_lanes;
    prefetch_bytes(&spheres + prefetch_distance, sizeof(spheres));  // farther ahead than the hardware prefetcher
    const auto x = hn::Load(lanes, block.x.data() + i);
    const auto y = hn::Load(lanes, block.y.data() + i);
    const auto z = hn::Load(lanes, block.z.data() + i);
    const auto transformed = [&](auto a, auto b, auto c, auto offset)
                                 HWY_ATTR { return hn::MulAdd(a, x, hn::MulAdd(b, y, hn::MulAdd(c, z, offset))); };
    const auto dx = hn::Sub(transformed(r00, r01, r02, offset_x), hn::LoadU(lanes, spheres.x.data() + lane));
    const auto dy = hn::Sub(transformed(r10, r11, r12, offset_y), hn::LoadU(lanes, spheres.y.data() + lane));
    const auto dz = hn::Sub(transformed(r20, r21, r22, offset_z), hn::LoadU(lanes, spheres.z.data() + lane));
    const auto squared = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
    const auto radius = hn::Sub(hn::LoadU(lanes, spheres.radius_m.data() + lane),
                                hn::Add(slack, hn::Load(lanes, block.slack.data() + i)));
    // Negated below, so that a NaN counts as expired.
    const auto is_free = hn::And(hn::Gt(radius, hn::Zero(lanes)), hn::Lt(squared, hn::Mul(radius, radius)));
    const auto is_expired = hn::Not(hn::RebindMask(ints, is_free));
    // Always stored: a branch on whether there are any would often be mispredicted near a bone.
    const auto nodes = hn::Add(lane_indices, hn::Set(ints, static_cast<int>(node)));
    hn::StoreU(hn::Compress(nodes, is_expired), ints, expired + found);
    found += hn::CountTrue(ints, is_expired);
  }
  bone.count = found;
}

void sweep_all(const double* positions, std::size_t nodes, const std::array<double, 3>& origin_m, const int* is_queried,
               std::span<ClearanceCache::BoneSweep> bones) {
  Block block = {};  // the last vector may be only partly filled
  for (std::size_t first = 0; first < nodes; first += block_size) {
    const std::size_t count = std::min(block_size, nodes - first);
    load_block(positions + 3 * first, count, origin_m, is_queried + first, block);
    for (ClearanceCache::BoneSweep& bone : bones) {
      sweep_block(block, first, count, bone);
    }
  }
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(sweep_all);

namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double), "positions are read as one array of doubles");

Vec3 middle_of(const TriangleMesh& mesh) {
  const Eigen::AlignedBox3d box = bounding_box(mesh.vertices);
  return box.isEmpty() ? Vec3(Vec3::Zero()) : Vec3(box.center());
}

std::array<std::array<float, 3>, 3> inverse_rotation(const RigidMotion& pose) {
  std::array<std::array<float, 3>, 3> result{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      result[row][column] =
          static_cast<float>(pose.rotation(static_cast<Eigen::Index>(column), static_cast<Eigen::Index>(row)));
    }
  }
  return result;
}

}  // namespace

void ClearanceCache::reset(std::span<const Bone> bones, std::size_t nodes) {
  m_nodes = nodes;
  m_bones.clear();
  m_bones.reserve(bones.size());
  for (const Bone& bone : bones) {
    m_bones.push_back({middle_of(bone.surface.mesh), {}, {}, 0});
    take_up(static_cast<int>(m_bones.size()) - 1);
  }
  m_sweeps.reserve(bones.size());
  m_queried.clear();
  m_queried.reserve(nodes);
  m_is_queried.assign(padded(nodes), 0);
}

void ClearanceCache::leave_out(int bone) {
  SafeSpheres& spheres = m_bones[static_cast<std::size_t>(bone)];
  spheres = {spheres.middle_m, {}, {}, 0};
}

void ClearanceCache::take_up(int bone) {
  SafeSpheres& spheres = m_bones[static_cast<std::size_t>(bone)];
  spheres.blocks.assign(padded(m_nodes) / SafeSphereBlock::width, {});
  spheres.expired.assign(m_nodes + sweep_lanes, 0);
}

void ClearanceCache::collect_expired(std::span<const RigidMotion> poses, std::span<const Vec3> positions,
                                     std::span<const int> nodes) {
  assert(positions.size() == m_nodes && poses.size() == m_bones.size());
  if (!sweeps(nodes.size())) {
    for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
      if (!m_bones[bone].is_left_out()) collect_one_by_one(poses[bone], positions, nodes, m_bones[bone]);
    }
    return;
  }
  plan_sweep(nodes);
  const Vec3 origin_m = sweep_origin(poses);
  m_sweeps.clear();
  for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
    SafeSpheres& spheres = m_bones[bone];
    if (spheres.is_left_out()) continue;
    const Vec3 offset = poses[bone].apply_inverse(origin_m) - spheres.middle_m;
    m_sweeps.push_back(
        {spheres.blocks.data(),
         inverse_rotation(poses[bone]),
         {static_cast<float>(offset.x()), static_cast<float>(offset.y()), static_cast<float>(offset.z())},
         sweep_slack * static_cast<float>(offset.lpNorm<1>()),
         spheres.expired.data(),
         0});
  }
  HWY_DYNAMIC_DISPATCH(sweep_all)
  (positions.data()->data(), positions.size(), {origin_m.x(), origin_m.y(), origin_m.z()}, m_is_queried.data(),
   m_sweeps);
  auto sweep = m_sweeps.begin();
  for (SafeSpheres& spheres : m_bones) {
    if (!spheres.is_left_out()) spheres.expired_count = (sweep++)->count;
  }
}

/// Common to all bones and near them, so that few digits are lost in single precision.
Vec3 ClearanceCache::sweep_origin(std::span<const RigidMotion> poses) const {
  const auto swept = std::ranges::count_if(m_bones, [](const SafeSpheres& each) { return !each.is_left_out(); });
  Vec3 origin_m = Vec3::Zero();
  for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
    if (!m_bones[bone].is_left_out()) {
      origin_m += poses[bone].apply(m_bones[bone].middle_m) / static_cast<double>(swept);
    }
  }
  return origin_m;
}

/// Kept from sweep to sweep: the free nodes of a muscle stay the same.
void ClearanceCache::plan_sweep(std::span<const int> nodes) {
  if (std::equal(nodes.begin(), nodes.end(), m_queried.begin(), m_queried.end())) {
    return;
  }
  m_queried.assign(nodes.begin(), nodes.end());
  std::fill(m_is_queried.begin(), m_is_queried.end(), 0);
  for (const int node : nodes) {
    m_is_queried[static_cast<std::size_t>(node)] = -1;
  }
}

void ClearanceCache::collect_one_by_one(const RigidMotion& pose, std::span<const Vec3> positions,
                                        std::span<const int> nodes, SafeSpheres& spheres) {
  spheres.expired_count = 0;
  for (const int node : nodes) {
    const Vec3 point = pose.apply_inverse(positions[static_cast<std::size_t>(node)]) - spheres.middle_m;
    const SafeSphere sphere = spheres.of(node);
    const double radius_m = sphere.radius_m - sweep_slack * point.lpNorm<1>();
    if (!(radius_m > 0 && (point - sphere.centre_m).squaredNorm() < radius_m * radius_m)) {
      spheres.expired[spheres.expired_count++] = node;
    }
  }
}

ClearanceCache::SafeSphere ClearanceCache::SafeSpheres::of(int node) const {
  const auto index = static_cast<std::size_t>(node);
  const SafeSphereBlock& block = blocks[index / SafeSphereBlock::width];
  const std::size_t lane = index % SafeSphereBlock::width;
  return {Vec3(block.x[lane], block.y[lane], block.z[lane]), block.radius_m[lane]};
}

void ClearanceCache::store(int bone, int node, const Vec3& rest_point, double clearance_m) {
  SafeSpheres& spheres = m_bones[static_cast<std::size_t>(bone)];
  const auto index = static_cast<std::size_t>(node);
  SafeSphereBlock& block = spheres.blocks[index / SafeSphereBlock::width];
  const std::size_t lane = index % SafeSphereBlock::width;
  const Vec3 centre = rest_point - spheres.middle_m;
  const double radius_m = clearance_m * (1 - comparison_slack) - centre_slack * centre.lpNorm<1>();
  block.x[lane] = static_cast<float>(centre.x());
  block.y[lane] = static_cast<float>(centre.y());
  block.z[lane] = static_cast<float>(centre.z());
  block.radius_m[lane] = radius_m > 0 ? static_cast<float>(radius_m) : 0.0F;
}

double ClearanceCache::distance_outside_m(int bone, int node, const Vec3& rest_point) const {
  const SafeSpheres& spheres = m_bones[static_cast<std::size_t>(bone)];
  const SafeSphere sphere = spheres.of(node);
  if (!(sphere.radius_m > 0)) {
    return std::numeric_limits<double>::infinity();
  }
  const Vec3 point = rest_point - spheres.middle_m;
  return (point - sphere.centre_m).norm() * (1 + comparison_slack) + centre_slack * point.lpNorm<1>() - sphere.radius_m;
}

std::size_t ClearanceCache::bytes() const {
  std::size_t bytes = sizeof(*this) + (m_is_queried.size() + m_nodes) * sizeof(int);
  for (const SafeSpheres& spheres : m_bones) {
    bytes += sizeof(SafeSpheres) + sizeof(BoneSweep) + spheres.blocks.size() * sizeof(SafeSphereBlock) +
             spheres.expired.size() * sizeof(int);
  }
  return bytes;
}

ParameterSpec clearance_cache_parameter() {
  return parameter::choice({.name = "clearance_cache",
                            .choices = {"on", "off"},
                            .role = ParameterRole::clearance_cache,
                            .help = "query a node again only after it moved by its clearance relative to the bone; the "
                                    "contacts stay the same"});
}

bool uses_clearance_cache(const Parameters& parameters) { return parameters.word("clearance_cache") == "on"; }

}  // namespace musclebench
#endif
