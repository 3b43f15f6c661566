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
std::vector<Bone> bones_at(const Vec3& offset) {
  TriangleMesh mesh = make_box(Vec3(0.1, 0.07, 0.05), 1);
  for (Vec3& vertex : mesh.vertices) {
    vertex += offset;
  }
  return {{"box", {mesh, true, {}}}};
}

std::vector<int> expired_of(ClearanceCache& cache, const std::vector<Vec3>& positions, const std::vector<int>& nodes) {
  const RigidMotion pose;
  cache.collect_expired({&pose, 1}, positions, nodes);
  const std::span<const int> expired = cache.expired(0);
  return {expired.begin(), expired.end()};
}

class ClearanceCacheAt : public testing::TestWithParam<double> {};

/// A node that has left its safe sphere, by however little, is never taken for free; and few nodes inside expire.
TEST_P(ClearanceCacheAt, ExpiredIsWhatHasLeftItsSafeSphere) {
  const double far_m = GetParam();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  const Vec3 middle = far_m * Vec3(1, -2, 0.5);
  const std::vector<Bone> bones = bones_at(middle);
  const std::vector<int> nodes = first_nodes(3001);
  ClearanceCache cache;
  cache.reset(bones, nodes.size());
  const RigidMotion pose = RigidMotion::about_axis(Vec3(1, 2, -0.5).normalized(), middle + Vec3(0.01, 0.2, 0), 0.9) *
                           RigidMotion{Mat3::Identity(), far_m * Vec3(0.3, 0.1, 0.7)};
  std::vector<Vec3> positions;
  std::vector<double> left_by;  // relative to the radius; positive: outside
  for (const int node : nodes) {
    const Vec3 centre = middle + 0.2 * vector();
    const double clearance_m = std::pow(10.0, -4 + 3 * std::abs(unit(random)));
    cache.store(0, node, centre, clearance_m);
    left_by.push_back((node % 2 == 0 ? 1 : -1) * std::pow(10.0, -9 * std::abs(unit(random))));
    positions.push_back(pose.apply(centre + (1 + left_by.back()) * clearance_m * vector().normalized()));
  }
  cache.collect_expired({&pose, 1}, positions, nodes);
  const std::span<const int> expired = cache.expired(0);
  const std::set<int> queried(expired.begin(), expired.end());
  ASSERT_EQ(queried.size(), expired.size());
  EXPECT_TRUE(std::is_sorted(expired.begin(), expired.end()));
  int needless = 0;
  for (const int node : nodes) {
    if (left_by[static_cast<std::size_t>(node)] > 0) {
      EXPECT_TRUE(queried.count(node)) << node << " left by " << left_by[static_cast<std::size_t>(node)];
    } else if (left_by[static_cast<std::size_t>(node)] < -0.01) {
      needless += static_cast<int>(queried.count(node));
    }
  }
  EXPECT_EQ(needless, 0);
}

INSTANTIATE_TEST_SUITE_P(Frames, ClearanceCacheAt, testing::Values(0.0, 10.0, 1e4));

/// Two spheres are taken to overlap by it.
TEST_P(ClearanceCacheAt, DistanceOutsideIsAnUpperBound) {
  const double far_m = GetParam();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  const Vec3 middle = far_m * Vec3(1, -2, 0.5);
  const std::vector<Bone> bones = bones_at(middle);
  ClearanceCache cache;
  cache.reset(bones, 2);
  EXPECT_EQ(cache.distance_outside_m(0, 0, middle), std::numeric_limits<double>::infinity());
  EXPECT_EQ(cache.radius_m(0, 0), 0);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 centre = middle + 0.2 * vector();
    const double clearance_m = std::pow(10.0, -4 + 3 * std::abs(unit(random)));
    cache.store(0, 1, centre, clearance_m);
    EXPECT_LE(cache.radius_m(0, 1), clearance_m);
    const Vec3 point =
        centre + (1 + std::pow(10.0, -1 - 8 * std::abs(unit(random)))) * clearance_m * vector().normalized();
    const double distance_m = (point - centre).norm() - clearance_m;
    EXPECT_GE(cache.distance_outside_m(0, 1, point), distance_m);
    EXPECT_LE(cache.distance_outside_m(0, 1, point), distance_m + 1e-5 * clearance_m + 1e-6);
  }
}

/// In a sweep positions are relative to the middle of all bones, one by one relative to the bone's own.
TEST_P(ClearanceCacheAt, BonesThatStandApartAreSweptAsIfEachWereAlone) {
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
  ClearanceCache cache;
  cache.reset(bones, nodes.size());
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
      const double distance_m = clearance_m * (1 + (left ? 1e-7 : -0.2));
      const Vec3 at = poses[static_cast<std::size_t>(bone)].apply_inverse(positions.back());
      cache.store(bone, node, at + distance_m * vector().normalized(), clearance_m);
      if (left) {
        outside[static_cast<std::size_t>(bone)].push_back(node);
      }
    }
  }
  // A hundredth of the nodes is tested one by one instead.
  for (const std::size_t count : {nodes.size(), nodes.size() / 100}) {
    cache.collect_expired(poses, positions, std::span(nodes).first(count));
    for (const int bone : {0, 1}) {
      const std::span<const int> expired = cache.expired(bone);
      std::vector<int> expected = outside[static_cast<std::size_t>(bone)];
      expected.erase(std::lower_bound(expected.begin(), expected.end(), static_cast<int>(count)), expected.end());
      EXPECT_TRUE(std::includes(expired.begin(), expired.end(), expected.begin(), expected.end())) << bone;
      if (far_m <=
          10) {  // farther apart than that, spheres of a millimetre are lost in rounding, which costs time only
        EXPECT_EQ(expired.size(), expected.size()) << bone;
      }
    }
  }
}

TEST(ClearanceCache, NodesThatAreNotQueriedDoNotExpire) {
  const std::vector<Bone> bones = bones_at(Vec3::Zero());
  ClearanceCache cache;
  cache.reset(bones, 700);
  const std::vector<Vec3> positions(700, Vec3(0.3, 0, 0));
  const std::vector<int> nodes = {2, 3, 5, 600, 699};
  cache.store(0, 3, positions[3], 0.1);
  cache.store(0, 600, positions[600], 0.1);
  EXPECT_EQ(expired_of(cache, positions, nodes), (std::vector<int>{2, 5, 699}));
  EXPECT_TRUE(expired_of(cache, positions, {}).empty());
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
    EXPECT_EQ(expired_of(cache, positions, most), expected) << left_out;
  }
}

TEST(ClearanceCache, NothingIsFreeWithoutASphereOrAFinitePosition) {
  const std::vector<Bone> bones = bones_at(Vec3::Zero());
  ClearanceCache cache;
  cache.reset(bones, 6);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  std::vector<Vec3> positions(6, Vec3(0.3, 0, 0));
  for (const int node : first_nodes(6)) {
    cache.store(0, node, positions[static_cast<std::size_t>(node)], 0.2);
  }
  positions[0].x() = nan;
  positions[1].y() = infinity;
  positions[2].z() = 1e300;
  cache.store(0, 3, positions[3], 0);
  cache.store(0, 4, positions[4], -1);
  EXPECT_EQ(expired_of(cache, positions, first_nodes(6)), (std::vector<int>{0, 1, 2, 3, 4}));
  cache.store(0, 5, positions[5], nan);
  EXPECT_EQ(expired_of(cache, positions, first_nodes(6)).size(), 6U);
}

}  // namespace
}  // namespace musclebench
