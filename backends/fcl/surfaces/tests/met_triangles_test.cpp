#include "backends/fcl/surfaces/met_triangles.hpp"

#include <array>
#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

struct Met {
  int triangle = -1;
  std::array<Vec3, 3> corners;
};

/// What a node at `point` keeps of the triangles that it meets in this order, in one round.
MetTriangles::Closest closest_of(const Vec3& point, const std::vector<Met>& met) {
  MetTriangles triangles(1);
  triangles.start_round();
  for (const auto& [triangle, corners] : met) {
    triangles.meet(
        0, [&] { return point; }, triangle, corners[0], corners[1], corners[2]);
  }
  return *triangles.find(0);
}

class MetTrianglesTest : public testing::Test {
 protected:
  // Two halves of a unit square at z = 0, and one a metre below.
  const std::array<Vec3, 3> m_lower_half{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0)};
  const std::array<Vec3, 3> m_upper_half{Vec3(0, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)};
  const std::array<Vec3, 3> m_below{Vec3(0, 0, -1), Vec3(1, 0, -1), Vec3(1, 1, -1)};
};

TEST_F(MetTrianglesTest, TheClosestIsKeptWhateverTheOrder) {
  const Vec3 point(0.75, 0.25, 0.5);
  for (const auto& met : {std::vector<Met>{{4, m_lower_half}, {2, m_below}}, {{2, m_below}, {4, m_lower_half}}}) {
    const MetTriangles::Closest closest = closest_of(point, met);
    EXPECT_EQ(closest.triangle, 4);
    EXPECT_EQ(closest.found.squared_distance_m2, 0.25);
    EXPECT_EQ(closest.point, point);
  }
}

TEST_F(MetTrianglesTest, OfTwoAtOneDistanceTheSmallestIndexIsKeptWhateverTheOrder) {
  const Vec3 above_the_shared_side(0.5, 0.5, 0.5);
  EXPECT_EQ(closest_of(above_the_shared_side, {{7, m_lower_half}, {3, m_upper_half}}).triangle, 3);
  EXPECT_EQ(closest_of(above_the_shared_side, {{3, m_upper_half}, {7, m_lower_half}}).triangle, 3);
}

TEST_F(MetTrianglesTest, ARoundForgetsTheOneBeforeAndANodeThatMetNothingHasNone) {
  MetTriangles triangles(2);
  triangles.start_round();
  const auto meet = [&](int triangle, const std::array<Vec3, 3>& corners) {
    triangles.meet(
        1, [] { return Vec3(0.75, 0.25, 0.5); }, triangle, corners[0], corners[1], corners[2]);
  };
  meet(4, m_lower_half);
  EXPECT_EQ(triangles.find(0), nullptr);
  ASSERT_NE(triangles.find(1), nullptr);
  triangles.start_round();
  EXPECT_EQ(triangles.find(1), nullptr);
  meet(2, m_below);
  EXPECT_EQ(triangles.find(1)->triangle, 2);
  EXPECT_EQ(triangles.find(1)->found.squared_distance_m2, 2.25);
}

}  // namespace
}  // namespace musclebench
