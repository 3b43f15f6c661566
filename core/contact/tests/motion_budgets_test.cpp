#include "core/contact/motion_budgets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "core/geometry/shapes.hpp"

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
  MotionBudgets budgets;
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
  std::vector<int> spent;
  budgets.collect_spent(0, pose, positions, nodes, spent);
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
  MotionBudgets budgets;
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

TEST(MotionBudgets, PlacesCountInTheNodesAskedFor) {
  const std::vector<Bone> bones = bones_at(Vec3::Zero());
  MotionBudgets budgets;
  budgets.reset(bones, 700);
  const std::vector<Vec3> positions(700, Vec3(0.3, 0, 0));
  const std::vector<int> nodes = {2, 3, 5, 600, 699};
  budgets.grant(0, 3, positions[3], 0.1);
  budgets.grant(0, 600, positions[600], 0.1);
  std::vector<int> spent;
  budgets.collect_spent(0, RigidMotion{}, positions, nodes, spent);
  EXPECT_EQ(spent, (std::vector<int>{0, 2, 4}));
  budgets.collect_spent(0, RigidMotion{}, positions, {}, spent);
  EXPECT_TRUE(spent.empty());
  // Enough nodes to be swept together: all but every third one, and then all but every fourth.
  for (const int left_out : {3, 4}) {
    std::vector<int> most;
    std::vector<int> expected;
    for (const int node : first_nodes(700)) {
      if (node % left_out != 0) {
        if (node != 3 && node != 600) {
          expected.push_back(static_cast<int>(most.size()));
        }
        most.push_back(node);
      }
    }
    budgets.collect_spent(0, RigidMotion{}, positions, most, spent);
    EXPECT_EQ(spent, expected) << left_out;
  }
}

TEST(MotionBudgets, NothingIsFreeWithoutABallOrANumber) {
  const std::vector<Bone> bones = bones_at(Vec3::Zero());
  MotionBudgets budgets;
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
  std::vector<int> spent;
  budgets.collect_spent(0, RigidMotion{}, positions, first_nodes(6), spent);
  EXPECT_EQ(spent, (std::vector<int>{0, 1, 2, 3, 4}));
  budgets.grant(0, 5, positions[5], nan);
  budgets.collect_spent(0, RigidMotion{}, positions, first_nodes(6), spent);
  EXPECT_EQ(spent.size(), 6U);
}

}  // namespace
}  // namespace musclebench
