#include "core/contact/muscle_contact.hpp"

#include <array>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random_numbers.hpp"
#include "core/mesh/tests/random_points.hpp"

namespace musclebench {
namespace {

/// Whatever feature of the triangle is closest: face, each edge, each corner.
TEST(MuscleContact, WeightsAreThoseOfTheClosestPoint) {
  RandomNumbers random(8);
  std::array<int, 7> met{};
  for (int trial = 0; trial < 2000; ++trial) {
    std::array<Vec3, 3> corners;
    for (Vec3& corner : corners) corner = random_point(random, -Vec3::Ones(), Vec3::Ones());
    const Vec3 point = random_point(random, -2 * Vec3::Ones(), 2 * Vec3::Ones());
    const ClosestOnTriangle closest = closest_on_triangle(point, corners[0], corners[1], corners[2]);
    const MuscleContact contact = muscle_contact_at(7, 2, point, 5, corners, closest);
    EXPECT_EQ(contact.node, 7);
    EXPECT_EQ(contact.muscle, 2);
    EXPECT_EQ(contact.triangle, 5);
    Vec3 on_triangle = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i) on_triangle += contact.weights[static_cast<Eigen::Index>(i)] * corners[i];
    ASSERT_LT((on_triangle - closest.point).norm(), 1e-12) << "feature " << static_cast<int>(closest.feature);
    ASSERT_NEAR(contact.weights.sum(), 1, 1e-15);
    ASSERT_GE(contact.weights.minCoeff(), 0);
    ASSERT_LT((point + contact.depth_m * contact.normal - closest.point).norm(), 1e-14);
    ++met[static_cast<std::size_t>(closest.feature)];
  }
  for (const int count : met) EXPECT_GT(count, 50);
}

TEST(MuscleContact, OfATriangleWithoutAreaHasWeightsAllTheSame) {
  const std::array<std::array<Vec3, 3>, 2> flat = {
      {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)}, {Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1)}}};
  for (const std::array<Vec3, 3>& corners : flat) {
    for (const Feature feature : {Feature::face, Feature::edge_0, Feature::edge_1, Feature::edge_2}) {
      const MuscleContact contact = muscle_contact_at(0, 1, Vec3(1, 2, 1), 0, corners, {corners[1], 1, feature});
      EXPECT_NEAR(contact.weights.sum(), 1, 1e-15);
      EXPECT_GE(contact.weights.minCoeff(), 0);
    }
  }
}

TEST(MusclePairs, AreFoundInEitherOrder) {
  const std::vector<MusclePair> pairs = {{0, 1}, {0, 3}, {1, 3}, {2, 3}};
  EXPECT_EQ(pair_index(pairs, 3, 0), 1U);
  EXPECT_EQ(pair_index(pairs, 0, 3), 1U);
  EXPECT_EQ(muscles_beside(pairs, 3), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(muscles_beside(pairs, 0), (std::vector<int>{1, 3}));
  EXPECT_TRUE(muscles_beside(pairs, 4).empty());
}

}  // namespace
}  // namespace musclebench
