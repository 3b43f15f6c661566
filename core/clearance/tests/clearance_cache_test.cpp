#include "core/clearance/clearance_cache.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <span>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

std::vector<int> first_nodes(std::size_t count) {
  std::vector<int> nodes(count);
  for (std::size_t i = 0; i < count; ++i) {
    nodes[i] = static_cast<int>(i);
  }
  return nodes;
}

/// A bone whose rest frame's origin is far away from it, as scans have it.
std::vector<Bone> bones_at(const Vec3& place) {
  TriangleMesh mesh = make_box(Vec3(0.1, 0.07, 0.05), 1);
  for (Vec3& vertex : mesh.vertices) {
    vertex += place;
  }
  return {{"box", {mesh, true, {}}}};
}

std::vector<int> spent_of(ClearanceCache& budgets, const std::vector<Vec3>& positions, const std::vector<int>& nodes) {
  const RigidMotion pose;
  budgets.collect_spent({&pose, 1}, positions, nodes);
  const std::span<const int> spent = budgets.spent(0);
  return {spent.begin(), spent.end()};
}

class MotionBudgetsAt : public testing::TestWithParam<double> {};

/// The one promise: a node that has left its ball, by however little, is never taken for free. And nearly none is asked
/// about in vain.
TEST_P(MotionBudgetsAt, SpentIsWhatHasLeftItsBall) {
  const double far_m = GetParam();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  const Vec3 middle = far_m * Vec3(1, -2, 0.5);
  const std::vector<Bone> bones = bones_at(middle);
  const std::vector<int> nodes = first_nodes(3001);
  ClearanceCache budgets;
  budgets.reset(bones, nodes.size());
  const RigidMotion pose = RigidMotion::about_axis(Vec3(1, 2, -0.5).normalized(), middle + Vec3(0.01, 0.2, 0), 0.9) *
                           RigidMotion{Mat3::Identity(), far_m * Vec3(0.3, 0.1, 0.7)};
  std::vector<Vec3> positions;
  std::vector<double> left_by;  // share of the radius; positive: outside
  for (const int node : nodes) {
    const Vec3 place = middle + 0.2 * vector();
    const double clearance_m = std::pow(10.0, -4 + 3 * std::abs(unit(random)));
    budgets.grant(0, node, place, clearance_m);
    left_by.push_back((node % 2 == 0 ? 1 : -1) * std::pow(10.0, -9 * std::abs(unit(random))));
    positions.push_back(pose.apply(place + (1 + left_by.back()) * clearance_m * vector().normalized()));
  }
  budgets.collect_spent({&pose, 1}, positions, nodes);
  const std::span<const int> spent = budgets.spent(0);
  const std::set<int> asked(spent.begin(), spent.end());
  ASSERT_EQ(asked.size(), spent.size());
  EXPECT_TRUE(std::is_sorted(spent.begin(), spent.end()));
  int in_vain = 0;
  for (const int node : nodes) {
    if (left_by[static_cast<std::size_t>(node)] > 0) {
      EXPECT_TRUE(asked.count(node)) << node << " left by " << left_by[static_cast<std::size_t>(node)];
    } else if (left_by[static_cast<std::size_t>(node)] < -0.01) {
      in_vain += static_cast<int>(asked.count(node));
    }
  }
  EXPECT_EQ(in_vain, 0);
}

INSTANTIATE_TEST_SUITE_P(Frames, MotionBudgetsAt, testing::Values(0.0, 10.0, 1e4));

/// Whoever trusts it joins two balls: they must overlap.
TEST_P(MotionBudgetsAt, AGapIsNeverTooSmall) {
  const double far_m = GetParam();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  const Vec3 middle = far_m * Vec3(1, -2, 0.5);
  const std::vector<Bone> bones = bones_at(middle);
  ClearanceCache budgets;
  budgets.reset(bones, 2);
  EXPECT_EQ(budgets.gap_m(0, 0, middle), std::numeric_limits<double>::infinity());
  EXPECT_EQ(budgets.radius_m(0, 0), 0);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 place = middle + 0.2 * vector();
    const double clearance_m = std::pow(10.0, -4 + 3 * std::abs(unit(random)));
    budgets.grant(0, 1, place, clearance_m);
    EXPECT_LE(budgets.radius_m(0, 1), clearance_m);
    const Vec3 point =
        place + (1 + std::pow(10.0, -1 - 8 * std::abs(unit(random)))) * clearance_m * vector().normalized();
    const double gap_m = (point - place).norm() - clearance_m;
    EXPECT_GE(budgets.gap_m(0, 1, point), gap_m);
    EXPECT_LE(budgets.gap_m(0, 1, point), gap_m + 1e-5 * clearance_m + 1e-6);
  }
}

/// Swept together, each bone about the middle of all of them, and one by one, each about its own.
TEST_P(MotionBudgetsAt, BonesThatStandApartAreSweptAsIfTheyWereAlone) {
  const double far_m = GetParam();
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  std::vector<Bone> bones = bones_at(Vec3(0.1, 0.2, -0.3));
  bones.push_back(bones_at(far_m * Vec3(0.5, 1, 1)).front());
  const std::vector<int> nodes = first_nodes(1003);
  const std::vector<RigidMotion> poses = {
      RigidMotion::about_axis(Vec3::UnitY(), far_m * Vec3(1, 0, 2), 0.4),
      RigidMotion::about_axis(Vec3(2, 1, 0).normalized(), far_m * Vec3(0.5, 1, 1) + Vec3(0, 0.3, 0), -1.1)};
  ClearanceCache budgets;
  budgets.reset(bones, nodes.size());
  std::vector<Vec3> positions;
  std::vector<std::vector<int>> outside(2);
  for (const int node : nodes) {
    // At the first bone, or half-way between the two.
    const Vec3 other = poses[1].apply(far_m * Vec3(0.5, 1, 1));
    const Vec3 first = poses[0].apply(Vec3(0.1, 0.2, -0.3));
    positions.push_back((node % 2 == 0 ? first : Vec3(0.5 * (first + other))) + 0.3 * vector());
    for (const int bone : {0, 1}) {
      const double clearance_m = std::pow(10.0, -3 + 2 * std::abs(unit(random)));
      const bool left = unit(random) < 0;
      const double way_m = clearance_m * (1 + (left ? 1e-7 : -0.2));
      const Vec3 at = poses[static_cast<std::size_t>(bone)].apply_inverse(positions.back());
      budgets.grant(bone, node, at + way_m * vector().normalized(), clearance_m);
      if (left) {
        outside[static_cast<std::size_t>(bone)].push_back(node);
      }
    }
  }
  // A hundredth of the nodes is not swept but asked one by one.
  for (const std::size_t count : {nodes.size(), nodes.size() / 100}) {
    budgets.collect_spent(poses, positions, std::span(nodes).first(count));
    for (const int bone : {0, 1}) {
      const std::span<const int> spent = budgets.spent(bone);
      std::vector<int> expected = outside[static_cast<std::size_t>(bone)];
      expected.erase(std::lower_bound(expected.begin(), expected.end(), static_cast<int>(count)), expected.end());
      EXPECT_TRUE(std::includes(spent.begin(), spent.end(), expected.begin(), expected.end())) << bone;
      if (far_m <= 10) {  // farther apart than that, balls of a millimetre get lost, which costs time only
        EXPECT_EQ(spent.size(), expected.size()) << bone;
      }
    }
  }
}

TEST(ClearanceCache, NodesThatAreNotAskedForAreNotSpent) {
  const std::vector<Bone> bones = bones_at(Vec3::Zero());
  ClearanceCache budgets;
  budgets.reset(bones, 700);
  const std::vector<Vec3> positions(700, Vec3(0.3, 0, 0));
  const std::vector<int> nodes = {2, 3, 5, 600, 699};
  budgets.grant(0, 3, positions[3], 0.1);
  budgets.grant(0, 600, positions[600], 0.1);
  EXPECT_EQ(spent_of(budgets, positions, nodes), (std::vector<int>{2, 5, 699}));
  EXPECT_TRUE(spent_of(budgets, positions, {}).empty());
  // Enough nodes to be swept together: all but every third one, and then all but every fourth.
  for (const int left_out : {3, 4}) {
    std::vector<int> most;
    std::vector<int> expected;
    for (const int node : first_nodes(700)) {
      if (node % left_out != 0) {
        if (node != 3 && node != 600) {
          expected.push_back(node);
        }
        most.push_back(node);
      }
    }
    EXPECT_EQ(spent_of(budgets, positions, most), expected) << left_out;
  }
}

TEST(ClearanceCache, NothingIsFreeWithoutABallOrANumber) {
  const std::vector<Bone> bones = bones_at(Vec3::Zero());
  ClearanceCache budgets;
  budgets.reset(bones, 6);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  std::vector<Vec3> positions(6, Vec3(0.3, 0, 0));
  for (const int node : first_nodes(6)) {
    budgets.grant(0, node, positions[static_cast<std::size_t>(node)], 0.2);
  }
  positions[0].x() = nan;
  positions[1].y() = infinity;
  positions[2].z() = 1e300;
  budgets.grant(0, 3, positions[3], 0);
  budgets.grant(0, 4, positions[4], -1);
  EXPECT_EQ(spent_of(budgets, positions, first_nodes(6)), (std::vector<int>{0, 1, 2, 3, 4}));
  budgets.grant(0, 5, positions[5], nan);
  EXPECT_EQ(spent_of(budgets, positions, first_nodes(6)).size(), 6U);
}

}  // namespace
}  // namespace musclebench
