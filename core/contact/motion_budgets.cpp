#include "core/contact/motion_budgets.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <limits>

#include "core/geometry/mesh_size.hpp"

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

/// Not more, whatever the machine has: a sweep is a short burst between milliseconds of scalar code, and registers of
/// 64 bytes would have to be woken up for it, which costs more than they give.
constexpr std::size_t sweep_lanes = 8;
/// Nodes that are looked at together; their positions stay in the first-level cache.
constexpr std::size_t block_size = 256;

/// Row i takes a position about the bone's middle to the bone's axis i.
using SweepRotation = std::array<std::array<float, 3>, 3>;

/// One bone's balls, and where it stands.
struct Sweep {
  const float* x;
  const float* y;
  const float* z;
  const float* radius_m;
  const int* place;  ///< negative: not asked for
  SweepRotation rotation;
  std::array<double, 3> middle_m;  ///< world
};

/// A position's way through single precision (its rounding, the rotation's, three products and sums) loses at most
/// 9 units of 2^-24 of the sum of its coordinates' sizes; this is twice that.
constexpr float sweep_slack = 1.1e-6F;
/// The same for the place that a budget is granted at, and for the comparison of squares.
constexpr double grant_slack = 2.5e-7;
constexpr double comparison_slack = 2e-6;

/// A subset that is smaller than this share of all nodes is asked one by one.
constexpr std::size_t sweep_share = 4;

constexpr std::size_t padded(std::size_t nodes) { return (nodes + sweep_lanes - 1) / sweep_lanes * sweep_lanes; }

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// World positions about the bone's middle, side by side.
struct alignas(64) Block {
  std::array<float, block_size> x, y, z;
};

HWY_INLINE void load_block(const double* HWY_RESTRICT positions, std::size_t count,
                           const std::array<double, 3>& middle_m, Block& block) {
  const hn::CappedTag<double, sweep_lanes / 2> wide;
  const hn::Rebind<float, decltype(wide)> narrow;
  const auto middle_x = hn::Set(wide, middle_m[0]);
  const auto middle_y = hn::Set(wide, middle_m[1]);
  const auto middle_z = hn::Set(wide, middle_m[2]);
  const std::size_t step = hn::Lanes(wide);
  std::size_t i = 0;
  for (; i + step <= count; i += step) {
    auto x = middle_x, y = middle_y, z = middle_z;
    hn::LoadInterleaved3(wide, positions + 3 * i, x, y, z);
    hn::Store(hn::DemoteTo(narrow, hn::Sub(x, middle_x)), narrow, block.x.data() + i);
    hn::Store(hn::DemoteTo(narrow, hn::Sub(y, middle_y)), narrow, block.y.data() + i);
    hn::Store(hn::DemoteTo(narrow, hn::Sub(z, middle_z)), narrow, block.z.data() + i);
  }
  for (; i < count; ++i) {
    block.x[i] = static_cast<float>(positions[3 * i] - middle_m[0]);
    block.y[i] = static_cast<float>(positions[3 * i + 1] - middle_m[1]);
    block.z[i] = static_cast<float>(positions[3 * i + 2] - middle_m[2]);
  }
}

/// The places of the nodes from `first` on that have left their balls, into `spent`; returns their number.
HWY_INLINE std::size_t sweep_block(const Sweep& sweep, const Block& block, std::size_t first, std::size_t count,
                                   int* HWY_RESTRICT spent) {
  const hn::CappedTag<float, sweep_lanes> lanes;
  const hn::RebindToSigned<decltype(lanes)> places;
  const auto entry = [&](std::size_t row, std::size_t column)
                         HWY_ATTR { return hn::Set(lanes, sweep.rotation[row][column]); };
  const auto r00 = entry(0, 0), r01 = entry(0, 1), r02 = entry(0, 2);
  const auto r10 = entry(1, 0), r11 = entry(1, 1), r12 = entry(1, 2);
  const auto r20 = entry(2, 0), r21 = entry(2, 1), r22 = entry(2, 2);
  const auto slack = hn::Set(lanes, sweep_slack);
  const std::size_t step = hn::Lanes(lanes);
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; i += step) {
    const std::size_t node = first + i;
    const auto x = hn::Load(lanes, block.x.data() + i);
    const auto y = hn::Load(lanes, block.y.data() + i);
    const auto z = hn::Load(lanes, block.z.data() + i);
    const auto turned = [&](auto a, auto b, auto c)
                            HWY_ATTR { return hn::MulAdd(a, x, hn::MulAdd(b, y, hn::Mul(c, z))); };
    const auto dx = hn::Sub(turned(r00, r01, r02), hn::LoadU(lanes, sweep.x + node));
    const auto dy = hn::Sub(turned(r10, r11, r12), hn::LoadU(lanes, sweep.y + node));
    const auto dz = hn::Sub(turned(r20, r21, r22), hn::LoadU(lanes, sweep.z + node));
    const auto squared = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
    const auto size = hn::Add(hn::Abs(x), hn::Add(hn::Abs(y), hn::Abs(z)));
    const auto radius = hn::NegMulAdd(slack, size, hn::LoadU(lanes, sweep.radius_m + node));
    // Written so that what is not a number is spent.
    const auto free = hn::And(hn::Gt(radius, hn::Zero(lanes)), hn::Lt(squared, hn::Mul(radius, radius)));
    const auto place = hn::LoadU(places, sweep.place + node);
    const auto asked = hn::Gt(place, hn::Set(places, -1));
    found += hn::CompressStore(place, hn::AndNot(hn::RebindMask(places, free), asked), places, spent + found);
  }
  return found;
}

std::size_t sweep_all(const Sweep& sweep, const double* positions, std::size_t nodes, int* spent) {
  Block block = {};  // whole vectors are read
  std::size_t found = 0;
  for (std::size_t first = 0; first < nodes; first += block_size) {
    const std::size_t count = std::min(block_size, nodes - first);
    load_block(positions + 3 * first, count, sweep.middle_m, block);
    found += sweep_block(sweep, block, first, count, spent + found);
  }
  return found;
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(sweep_all);

namespace {

static_assert(MotionBudgets::room_behind >= sweep_lanes);
static_assert(sizeof(Vec3) == 3 * sizeof(double), "positions are read as a row of numbers");

Vec3 middle_of(const TriangleMesh& mesh) {
  const Eigen::AlignedBox3d box = bounding_box(mesh.vertices);
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
  m_nodes = nodes;
  m_bones.clear();
  m_bones.reserve(bones.size());
  const std::vector<float> none(padded(nodes), 0.0F);
  for (const Bone& bone : bones) {
    m_bones.push_back({middle_of(bone.surface.mesh), none, none, none, none});
  }
  m_swept.clear();
  m_swept.reserve(nodes);
  m_place_of_node.assign(padded(nodes), -1);
}

void MotionBudgets::collect_spent(int bone, const RigidMotion& pose, std::span<const Vec3> positions,
                                  std::span<const int> nodes, std::vector<int>& spent) {
  assert(positions.size() == m_nodes);
  const Balls& balls = m_bones[static_cast<std::size_t>(bone)];
  if (nodes.size() < m_nodes / sweep_share || nodes.empty()) {
    collect_one_by_one(balls, pose, positions, nodes, spent);
    return;
  }
  plan_sweep(nodes);
  const Vec3 middle_m = pose.apply(balls.middle_m);
  const Sweep sweep{balls.x.data(),
                    balls.y.data(),
                    balls.z.data(),
                    balls.radius_m.data(),
                    m_place_of_node.data(),
                    inverse_rotation(pose),
                    {middle_m.x(), middle_m.y(), middle_m.z()}};
  spent.resize(nodes.size() + room_behind);  // a compressed vector is stored whole
  spent.resize(HWY_DYNAMIC_DISPATCH(sweep_all)(sweep, positions.data()->data(), positions.size(), spent.data()));
}

/// The free nodes of a muscle stay the same, step after step.
void MotionBudgets::plan_sweep(std::span<const int> nodes) {
  if (std::equal(nodes.begin(), nodes.end(), m_swept.begin(), m_swept.end())) {
    return;
  }
  m_swept.assign(nodes.begin(), nodes.end());
  std::fill(m_place_of_node.begin(), m_place_of_node.end(), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    m_place_of_node[static_cast<std::size_t>(nodes[i])] = static_cast<int>(i);
  }
}

void MotionBudgets::collect_one_by_one(const Balls& balls, const RigidMotion& pose, std::span<const Vec3> positions,
                                       std::span<const int> nodes, std::vector<int>& spent) const {
  spent.clear();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto node = static_cast<std::size_t>(nodes[i]);
    const Vec3 place = pose.apply_inverse(positions[node]) - balls.middle_m;
    const double radius_m = static_cast<double>(balls.radius_m[node]) - sweep_slack * place.lpNorm<1>();
    const Vec3 ball(balls.x[node], balls.y[node], balls.z[node]);
    if (!(radius_m > 0 && (place - ball).squaredNorm() < radius_m * radius_m)) {
      spent.push_back(static_cast<int>(i));
    }
  }
}

void MotionBudgets::grant(int bone, int node, const Vec3& rest_point, double clearance_m) {
  Balls& balls = m_bones[static_cast<std::size_t>(bone)];
  const auto index = static_cast<std::size_t>(node);
  const Vec3 place = rest_point - balls.middle_m;
  const double radius_m = clearance_m * (1 - comparison_slack) - grant_slack * place.lpNorm<1>();
  balls.x[index] = static_cast<float>(place.x());
  balls.y[index] = static_cast<float>(place.y());
  balls.z[index] = static_cast<float>(place.z());
  balls.radius_m[index] = radius_m > 0 ? static_cast<float>(radius_m) : 0.0F;
}

double MotionBudgets::gap_m(int bone, int node, const Vec3& rest_point) const {
  const Balls& balls = m_bones[static_cast<std::size_t>(bone)];
  const auto index = static_cast<std::size_t>(node);
  if (!(balls.radius_m[index] > 0)) {
    return std::numeric_limits<double>::infinity();
  }
  const Vec3 ball(balls.x[index], balls.y[index], balls.z[index]);
  const Vec3 place = rest_point - balls.middle_m;
  return (place - ball).norm() * (1 + comparison_slack) + grant_slack * place.lpNorm<1>() -
         static_cast<double>(balls.radius_m[index]);
}

std::size_t MotionBudgets::bytes() const {
  return sizeof(*this) + m_bones.size() * (sizeof(Balls) + 4 * padded(m_nodes) * sizeof(float)) +
         (padded(m_nodes) + m_nodes) * sizeof(int);
}

ParameterSpec motion_budgets_parameter(bool on_by_default) {
  return {.name = "motion_budgets",
          .default_value = std::string(on_by_default ? "on" : "off"),
          .help =
              "ask about a node again only when it and the bone together have moved as far as it was away; the "
              "contacts are the same",
          .choices = {"on", "off"}};
}

bool has_motion_budgets(const Parameters& parameters) { return parameters.word("motion_budgets") == "on"; }

}  // namespace musclebench
#endif
