#include "core/contact/motion_budgets.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

// Includes this file once for every kind of SIMD; highway.h has to come after it.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/contact/motion_budgets.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#ifndef MUSCLEBENCH_MOTION_BUDGETS_ONCE
#define MUSCLEBENCH_MOTION_BUDGETS_ONCE
namespace musclebench {

/// Nodes that are looked at together; their data stay in the first-level cache.
constexpr std::size_t block_size = 256;
/// What `CompressStore` may write beyond the last lane that counts.
constexpr std::size_t room_behind = 64;

/// Positions about the bone's middle (world axes), and the balls of the same nodes, side by side.
struct alignas(64) SweepBlock {
  std::array<float, block_size> x, y, z;
  std::array<float, block_size> ball_x, ball_y, ball_z, radius_m;
};

/// Row i takes a position about the bone's middle to the bone's axis i.
using SweepRotation = std::array<std::array<float, 3>, 3>;

/// A position's way through single precision (its rounding, the rotation's, three products and sums) loses at most
/// 9 units of 2^-24 of the sum of its coordinates' sizes; this is twice that.
constexpr float sweep_slack = 1.1e-6F;
/// The same for the place that a budget is granted at, and for the comparison of squares.
constexpr double grant_slack = 2.5e-7;
constexpr double comparison_slack = 2e-6;

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Appends `first` + place of every node that has left its ball; returns their number.
std::size_t sweep_block(const SweepBlock& block, std::size_t count, const SweepRotation& rotation, std::int32_t first,
                        std::int32_t* spent) {
  const hn::ScalableTag<float> lanes;
  const hn::RebindToSigned<decltype(lanes)> places;
  const auto entry = [&](std::size_t row, std::size_t column) { return hn::Set(lanes, rotation[row][column]); };
  const auto r00 = entry(0, 0), r01 = entry(0, 1), r02 = entry(0, 2);
  const auto r10 = entry(1, 0), r11 = entry(1, 1), r12 = entry(1, 2);
  const auto r20 = entry(2, 0), r21 = entry(2, 1), r22 = entry(2, 2);
  const auto slack = hn::Set(lanes, sweep_slack);
  const std::size_t step = hn::Lanes(lanes);
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; i += step) {
    const auto x = hn::Load(lanes, block.x.data() + i);
    const auto y = hn::Load(lanes, block.y.data() + i);
    const auto z = hn::Load(lanes, block.z.data() + i);
    const auto turned = [&](auto a, auto b, auto c) { return hn::MulAdd(a, x, hn::MulAdd(b, y, hn::Mul(c, z))); };
    const auto dx = hn::Sub(turned(r00, r01, r02), hn::Load(lanes, block.ball_x.data() + i));
    const auto dy = hn::Sub(turned(r10, r11, r12), hn::Load(lanes, block.ball_y.data() + i));
    const auto dz = hn::Sub(turned(r20, r21, r22), hn::Load(lanes, block.ball_z.data() + i));
    const auto squared = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
    const auto size = hn::Add(hn::Abs(x), hn::Add(hn::Abs(y), hn::Abs(z)));
    const auto radius = hn::NegMulAdd(slack, size, hn::Load(lanes, block.radius_m.data() + i));
    // Written so that what is not a number is spent.
    const auto free = hn::And(hn::Gt(radius, hn::Zero(lanes)), hn::Lt(squared, hn::Mul(radius, radius)));
    const auto in_block = hn::FirstN(lanes, count - i);
    const auto is_spent = hn::RebindMask(places, hn::AndNot(free, in_block));
    const auto place = hn::Iota(places, first + static_cast<std::int32_t>(i));
    found += hn::CompressStore(place, is_spent, places, spent + found);
  }
  return found;
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(sweep_block);

namespace {

Vec3 middle_of(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : mesh.vertices) {
    box.extend(vertex);
  }
  return box.isEmpty() ? Vec3(Vec3::Zero()) : Vec3(box.center());
}

SweepRotation inverse_rotation(const RigidMotion& pose) {
  SweepRotation result{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      result[row][column] =
          static_cast<float>(pose.rotation(static_cast<Eigen::Index>(column), static_cast<Eigen::Index>(row)));
    }
  }
  return result;
}

}  // namespace

void MotionBudgets::reset(std::span<const Bone> bones, std::size_t nodes) {
  m_bones.clear();
  m_bones.reserve(bones.size());
  for (const Bone& bone : bones) {
    m_bones.push_back({middle_of(bone.surface.mesh), std::vector<Ball>(nodes)});
  }
  m_ball_count = bones.size() * nodes;
}

void MotionBudgets::collect_spent(int bone, const RigidMotion& pose, std::span<const Vec3> positions,
                                  std::span<const int> nodes, std::vector<int>& spent) const {
  const BoneBalls& balls = m_bones[static_cast<std::size_t>(bone)];
  const SweepRotation rotation = inverse_rotation(pose);
  const Vec3 middle_m = pose.apply(balls.middle_m);
  const auto sweep = HWY_DYNAMIC_DISPATCH(sweep_block);
  spent.resize(nodes.size() + room_behind);
  std::size_t found = 0;
  SweepBlock block;
  for (std::size_t first = 0; first < nodes.size(); first += block_size) {
    const std::size_t count = std::min(block_size, nodes.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      const auto node = static_cast<std::size_t>(nodes[first + i]);
      const Vec3 about_middle = positions[node] - middle_m;
      const Ball& ball = balls.of_node[node];
      block.x[i] = static_cast<float>(about_middle.x());
      block.y[i] = static_cast<float>(about_middle.y());
      block.z[i] = static_cast<float>(about_middle.z());
      block.ball_x[i] = ball.x;
      block.ball_y[i] = ball.y;
      block.ball_z[i] = ball.z;
      block.radius_m[i] = ball.radius_m;
    }
    found += sweep(block, count, rotation, static_cast<std::int32_t>(first), spent.data() + found);
  }
  spent.resize(found);
}

void MotionBudgets::grant(int bone, int node, const Vec3& rest_point, double clearance_m) {
  BoneBalls& balls = m_bones[static_cast<std::size_t>(bone)];
  const Vec3 place = rest_point - balls.middle_m;
  const double radius_m = clearance_m * (1 - comparison_slack) - grant_slack * place.lpNorm<1>();
  balls.of_node[static_cast<std::size_t>(node)] = {static_cast<float>(place.x()), static_cast<float>(place.y()),
                                                   static_cast<float>(place.z()),
                                                   radius_m > 0 ? static_cast<float>(radius_m) : 0.0F};
}

ParameterSpec motion_budgets_parameter(bool on_by_default) {
  return {.name = "motion_budgets",
          .default_value = std::string(on_by_default ? "on" : "off"),
          .help = "ask about a node again only when it and the bone together have moved as far as it was away; the "
                  "contacts are the same",
          .choices = {"on", "off"}};
}

bool has_motion_budgets(const Parameters& parameters) { return parameters.word("motion_budgets") == "on"; }

}  // namespace musclebench
#endif
