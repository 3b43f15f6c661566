#include "core/clearance/clearance_cache.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <limits>
#include <span>

#include "core/base/prefetch.hpp"
#include "core/mesh/mesh_size.hpp"

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/clearance/clearance_cache.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#ifndef MUSCLEBENCH_MOTION_BUDGETS_ONCE
#define MUSCLEBENCH_MOTION_BUDGETS_ONCE
namespace musclebench {

/// Not more, whatever the machine has: a sweep is a short burst between milliseconds of scalar code, and registers of
/// 64 bytes would have to be woken up for it, which costs more than they give.
constexpr std::size_t sweep_lanes = 8;
/// Nodes that are looked at together; their positions stay in the first-level cache.
constexpr std::size_t block_size = 256;
/// Eight balls each.
constexpr std::size_t fetched_ahead = 20;

/// A position's way through single precision (its rounding, the rotation's, three products and sums) loses at most
/// 11 units of 2^-24 of the sum of its coordinates' sizes, and 7 of the offset's; this is more.
constexpr float sweep_slack = 1.1e-6F;
/// The same for the place that a budget is granted at, and for the comparison of squares.
constexpr double grant_slack = 2.5e-7;
constexpr double comparison_slack = 2e-6;

/// A subset that is smaller than this share of all nodes is asked one by one.
constexpr std::size_t sweep_share = 4;

constexpr std::size_t padded(std::size_t nodes) { return (nodes + sweep_lanes - 1) / sweep_lanes * sweep_lanes; }

static_assert(sweep_lanes == ClearanceCache::EightBalls::width && block_size % sweep_lanes == 0);

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// World positions about the sweep's middle, side by side, and what they lose. A node that is not asked about is at the
/// middle and loses less than nothing, so that it is in every ball.
struct alignas(64) Block {
  std::array<float, 3 * block_size> rows;  ///< node after node, before they are side by side
  std::array<float, block_size> x, y, z, slack;
};

/// `is_asked`: by node, 0 or -1.
HWY_INLINE void load_block(const double* HWY_RESTRICT positions, std::size_t count,
                           const std::array<double, 3>& middle_m, const int* HWY_RESTRICT is_asked, Block& block) {
  const hn::CappedTag<double, sweep_lanes / 2> wide;
  const hn::Rebind<float, decltype(wide)> narrow;
  const std::size_t step = hn::Lanes(wide);
  alignas(64) std::array<double, 3 + sweep_lanes / 2> repeated;
  for (std::size_t i = 0; i < repeated.size(); ++i) {
    repeated[i] = middle_m[i % 3];
  }
  const auto narrowed = [&](std::size_t at, auto middle) HWY_ATTR {
    hn::StoreU(hn::DemoteTo(narrow, hn::Sub(hn::LoadU(wide, positions + at), middle)), narrow, block.rows.data() + at);
  };
  const auto middle_0 = hn::LoadU(wide, repeated.data());
  const auto middle_1 = hn::LoadU(wide, repeated.data() + step % 3);
  const auto middle_2 = hn::LoadU(wide, repeated.data() + 2 * step % 3);
  std::size_t i = 0;
  for (; i + 3 * step <= 3 * count; i += 3 * step) {
    narrowed(i, middle_0);
    narrowed(i + step, middle_1);
    narrowed(i + 2 * step, middle_2);
  }
  for (; i < 3 * count; ++i) {
    block.rows[i] = static_cast<float>(positions[i] - middle_m[i % 3]);
  }
  const hn::CappedTag<float, sweep_lanes> lanes;
  const hn::RebindToSigned<decltype(lanes)> ints;
  const auto share = hn::Set(lanes, sweep_slack);
  const auto never_spent = hn::Set(lanes, -std::numeric_limits<float>::infinity());
  for (std::size_t node = 0; node < count; node += hn::Lanes(lanes)) {
    auto x = share, y = share, z = share;
    hn::LoadInterleaved3(lanes, block.rows.data() + 3 * node, x, y, z);
    const auto slack = hn::Mul(share, hn::Add(hn::Abs(x), hn::Add(hn::Abs(y), hn::Abs(z))));
    const auto asked = hn::RebindMask(lanes, hn::Lt(hn::LoadU(ints, is_asked + node), hn::Zero(ints)));
    hn::Store(hn::IfThenElseZero(asked, x), lanes, block.x.data() + node);
    hn::Store(hn::IfThenElseZero(asked, y), lanes, block.y.data() + node);
    hn::Store(hn::IfThenElseZero(asked, z), lanes, block.z.data() + node);
    hn::Store(hn::IfThenElse(asked, slack, never_spent), lanes, block.slack.data() + node);
  }
}

/// Of the nodes from `first` on those that have left their balls.
HWY_INLINE void sweep_block(const Block& block, std::size_t first, std::size_t count, ClearanceCache::SweptBone& bone) {
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
  // Once: from a node's number it would be stored in parts and read whole, for which the CPU waits.
  const auto places = hn::Iota(ints, 0);
  int* const spent = bone.spent;
  std::size_t found = bone.count;
  for (std::size_t i = 0; i < count; i += hn::Lanes(lanes)) {
    const std::size_t node = first + i;
    const ClearanceCache::EightBalls& balls = bone.balls[node / sweep_lanes];
    const std::size_t place = node % sweep_lanes;
    prefetch_bytes(&balls + fetched_ahead, sizeof(balls));  // sooner than the CPU would guess
    const auto x = hn::Load(lanes, block.x.data() + i);
    const auto y = hn::Load(lanes, block.y.data() + i);
    const auto z = hn::Load(lanes, block.z.data() + i);
    const auto turned = [&](auto a, auto b, auto c, auto offset)
                            HWY_ATTR { return hn::MulAdd(a, x, hn::MulAdd(b, y, hn::MulAdd(c, z, offset))); };
    const auto dx = hn::Sub(turned(r00, r01, r02, offset_x), hn::LoadU(lanes, balls.x.data() + place));
    const auto dy = hn::Sub(turned(r10, r11, r12, offset_y), hn::LoadU(lanes, balls.y.data() + place));
    const auto dz = hn::Sub(turned(r20, r21, r22, offset_z), hn::LoadU(lanes, balls.z.data() + place));
    const auto squared = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
    const auto radius = hn::Sub(hn::LoadU(lanes, balls.radius_m.data() + place),
                                hn::Add(slack, hn::Load(lanes, block.slack.data() + i)));
    // Written so that what is not a number is spent.
    const auto free = hn::And(hn::Gt(radius, hn::Zero(lanes)), hn::Lt(squared, hn::Mul(radius, radius)));
    // Without a branch, which would be guessed wrong as often as not where something is spent.
    const auto spent_now = hn::Not(hn::RebindMask(ints, free));
    hn::StoreU(hn::Compress(hn::Add(places, hn::Set(ints, static_cast<int>(node))), spent_now), ints, spent + found);
    found += hn::CountTrue(ints, spent_now);
  }
  bone.count = found;
}

void sweep_all(const double* positions, std::size_t nodes, const std::array<double, 3>& middle_m, const int* is_asked,
               std::span<ClearanceCache::SweptBone> bones) {
  Block block = {};  // whole vectors are read
  for (std::size_t first = 0; first < nodes; first += block_size) {
    const std::size_t count = std::min(block_size, nodes - first);
    load_block(positions + 3 * first, count, middle_m, is_asked + first, block);
    for (ClearanceCache::SweptBone& bone : bones) {
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

static_assert(sizeof(Vec3) == 3 * sizeof(double), "positions are read as a row of numbers");

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
    m_bones.push_back({middle_of(bone.surface.mesh), std::vector<EightBalls>(padded(nodes) / EightBalls::width),
                       std::vector<int>(nodes + sweep_lanes), 0});
  }
  m_sweeps.reserve(bones.size());
  m_swept.clear();
  m_swept.reserve(nodes);
  m_is_swept.assign(padded(nodes), 0);
}

void ClearanceCache::collect_spent(std::span<const RigidMotion> poses, std::span<const Vec3> positions,
                                   std::span<const int> nodes) {
  assert(positions.size() == m_nodes && poses.size() == m_bones.size());
  if (nodes.size() < m_nodes / sweep_share || nodes.empty()) {
    for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
      collect_one_by_one(poses[bone], positions, nodes, m_bones[bone]);
    }
    return;
  }
  plan_sweep(nodes);
  Vec3 middle_m = Vec3::Zero();
  for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
    middle_m += poses[bone].apply(m_bones[bone].middle_m) / static_cast<double>(m_bones.size());
  }
  m_sweeps.clear();
  for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
    Balls& balls = m_bones[bone];
    const Vec3 offset = poses[bone].apply_inverse(middle_m) - balls.middle_m;
    m_sweeps.push_back(
        {balls.eights.data(),
         inverse_rotation(poses[bone]),
         {static_cast<float>(offset.x()), static_cast<float>(offset.y()), static_cast<float>(offset.z())},
         sweep_slack * static_cast<float>(offset.lpNorm<1>()),
         balls.spent.data(),
         0});
  }
  HWY_DYNAMIC_DISPATCH(sweep_all)
  (positions.data()->data(), positions.size(), {middle_m.x(), middle_m.y(), middle_m.z()}, m_is_swept.data(), m_sweeps);
  for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
    m_bones[bone].spent_count = m_sweeps[bone].count;
  }
}

/// The free nodes of a muscle stay the same, step after step.
void ClearanceCache::plan_sweep(std::span<const int> nodes) {
  if (std::equal(nodes.begin(), nodes.end(), m_swept.begin(), m_swept.end())) {
    return;
  }
  m_swept.assign(nodes.begin(), nodes.end());
  std::fill(m_is_swept.begin(), m_is_swept.end(), 0);
  for (const int node : nodes) {
    m_is_swept[static_cast<std::size_t>(node)] = -1;
  }
}

void ClearanceCache::collect_one_by_one(const RigidMotion& pose, std::span<const Vec3> positions,
                                        std::span<const int> nodes, Balls& balls) {
  balls.spent_count = 0;
  for (const int node : nodes) {
    const Vec3 place = pose.apply_inverse(positions[static_cast<std::size_t>(node)]) - balls.middle_m;
    const Ball ball = balls.of(node);
    const double radius_m = ball.radius_m - sweep_slack * place.lpNorm<1>();
    if (!(radius_m > 0 && (place - ball.centre_m).squaredNorm() < radius_m * radius_m)) {
      balls.spent[balls.spent_count++] = node;
    }
  }
}

ClearanceCache::Ball ClearanceCache::Balls::of(int node) const {
  const auto index = static_cast<std::size_t>(node);
  const EightBalls& eight = eights[index / EightBalls::width];
  const std::size_t place = index % EightBalls::width;
  return {Vec3(eight.x[place], eight.y[place], eight.z[place]), eight.radius_m[place]};
}

void ClearanceCache::grant(int bone, int node, const Vec3& rest_point, double clearance_m) {
  Balls& balls = m_bones[static_cast<std::size_t>(bone)];
  const auto index = static_cast<std::size_t>(node);
  EightBalls& eight = balls.eights[index / EightBalls::width];
  const std::size_t at = index % EightBalls::width;
  const Vec3 place = rest_point - balls.middle_m;
  const double radius_m = clearance_m * (1 - comparison_slack) - grant_slack * place.lpNorm<1>();
  eight.x[at] = static_cast<float>(place.x());
  eight.y[at] = static_cast<float>(place.y());
  eight.z[at] = static_cast<float>(place.z());
  eight.radius_m[at] = radius_m > 0 ? static_cast<float>(radius_m) : 0.0F;
}

double ClearanceCache::gap_m(int bone, int node, const Vec3& rest_point) const {
  const Balls& balls = m_bones[static_cast<std::size_t>(bone)];
  const Ball ball = balls.of(node);
  if (!(ball.radius_m > 0)) {
    return std::numeric_limits<double>::infinity();
  }
  const Vec3 place = rest_point - balls.middle_m;
  return (place - ball.centre_m).norm() * (1 + comparison_slack) + grant_slack * place.lpNorm<1>() - ball.radius_m;
}

std::size_t ClearanceCache::bytes() const {
  std::size_t bytes = sizeof(*this) + (m_is_swept.size() + m_nodes) * sizeof(int);
  for (const Balls& balls : m_bones) {
    bytes +=
        sizeof(Balls) + sizeof(SweptBone) + balls.eights.size() * sizeof(EightBalls) + balls.spent.size() * sizeof(int);
  }
  return bytes;
}

ParameterSpec clearance_cache_parameter() {
  return parameter::choice({.name = "clearance_cache",
                            .choices = {"on", "off"},
                            .role = ParameterRole::clearance_cache,
                            .help = "ask about a node again only when it and the bone together have moved as far as it "
                                    "was away; the contacts are the same"});
}

bool uses_clearance_cache(const Parameters& parameters) { return parameters.word("clearance_cache") == "on"; }

}  // namespace musclebench
#endif
