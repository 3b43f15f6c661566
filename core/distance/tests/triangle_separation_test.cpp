#include "core/distance/triangle_separation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

constexpr double margin_m = 1e-9;
using Corners = std::array<Vec3, 3>;

class TriangleSeparation : public testing::Test {
 protected:
  Vec3 anywhere() {
    const double x = coordinate();
    const double y = coordinate();
    return {x, y, coordinate()};
  }
  Corners any_triangle() {
    const Vec3 a = anywhere();
    const Vec3 b = anywhere();
    return {a, b, anywhere()};
  }
  /// A point that is well inside.
  Vec3 inner_point(const Corners& corners) {
    const double v = 0.1 + 0.3 * (1 + coordinate()) / 2;
    const double w = 0.1 + 0.3 * (1 + coordinate()) / 2;
    return (1 - v - w) * corners[0] + v * corners[1] + w * corners[2];
  }
  double coordinate() { return m_coordinate(m_random); }

  /// Every order of the corners must give the same answer about whether they touch.
  static bool apart_in_any_order(const Triangle& one, const Corners& of_one, const Triangle& other,
                                 const Corners& of_other) {
    bool any = false;
    for (std::size_t turn = 0; turn < 9; ++turn) {
      const auto turned = [](const auto& values, std::size_t by) {
        auto result = values;
        for (std::size_t i = 0; i < 3; ++i) {
          result[i] = values[(i + by) % 3];
        }
        return result;
      };
      const Triangle a = turned(one, turn % 3);
      const Triangle b = turned(other, turn / 3);
      const Corners of_a = turned(of_one, turn % 3);
      const Corners of_b = turned(of_other, turn / 3);
      any = any || surely_apart({a, of_a}, {b, of_b}, margin_m) || surely_apart({b, of_b}, {a, of_a}, margin_m);
    }
    return any;
  }

 private:
  std::mt19937 m_random{41};
  std::uniform_real_distribution<double> m_coordinate{-1, 1};
};

TEST_F(TriangleSeparation, TrianglesWithACommonPointAreNeverApart) {
  for (int i = 0; i < 3000; ++i) {
    const Corners one = any_triangle();
    const Vec3 common = inner_point(one);
    Corners other = any_triangle();
    // Moved so that an inner point of it is an inner point of the first.
    const Vec3 step = common - inner_point(other);
    for (Vec3& corner : other) {
      corner += step;
    }
    EXPECT_FALSE(apart_in_any_order({0, 1, 2}, one, {3, 4, 5}, other));
    // A common vertex, and a side through the first.
    const Vec3 far_end = common + (i % 2 == 0 ? 0.5 : -0.3) * anywhere();
    EXPECT_FALSE(apart_in_any_order({0, 1, 2}, one, {0, 4, 5}, {one[0], far_end, 2 * common - far_end}));
    // A common side, folded onto the first; and the triangle itself.
    EXPECT_FALSE(apart_in_any_order({0, 1, 2}, one, {1, 0, 5}, {one[1], one[0], common}));
    EXPECT_FALSE(apart_in_any_order({0, 1, 2}, one, {2, 1, 0}, {one[2], one[1], one[0]}));
  }
}

TEST_F(TriangleSeparation, TrianglesThatTouchToRoundingAreNotApart) {
  for (int i = 0; i < 1000; ++i) {
    const Corners one = any_triangle();
    const Vec3 normal = (one[1] - one[0]).cross(one[2] - one[0]).normalized();
    const Vec3 common = inner_point(one);
    for (const double height : {0.0, 1e-16, 1e-11}) {
      const Corners touching = {common + height * normal, common + normal + 0.1 * anywhere(),
                                common + normal + 0.1 * anywhere()};
      EXPECT_FALSE(apart_in_any_order({0, 1, 2}, one, {3, 4, 5}, touching));
    }
    const Corners above = {common + 1e-8 * normal, common + normal + 0.1 * anywhere(),
                           common + normal + 0.1 * anywhere()};
    EXPECT_TRUE(apart_in_any_order({0, 1, 2}, one, {3, 4, 5}, above));
  }
}

TEST_F(TriangleSeparation, FindsAPlaneBetweenAnyTwoThatShareNothing) {
  int tried = 0;
  for (int i = 0; i < 3000; ++i) {
    const Corners one = any_triangle();
    Corners other = any_triangle();
    const Vec3 direction = anywhere().normalized();
    double lowest = 10;
    double highest = -10;
    for (std::size_t k = 0; k < 3; ++k) {
      highest = std::max(highest, direction.dot(one[k]));
      lowest = std::min(lowest, direction.dot(other[k]));
    }
    for (Vec3& corner : other) {
      corner += (highest - lowest + 1e-3) * direction;
    }
    ++tried;
    EXPECT_TRUE(surely_apart({{0, 1, 2}, one}, {{3, 4, 5}, other}, margin_m)) << i;
  }
  EXPECT_GT(tried, 0);
}

TEST_F(TriangleSeparation, NeighboursInAFanAreApart) {
  const int count = 6;
  std::vector<Vec3> ring;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    ring.emplace_back(std::cos(angle), std::sin(angle), 0.2 * (i % 2));
  }
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < i; ++j) {
      const Triangle one = {0, 1 + i, 1 + (i + 1) % count};
      const Triangle other = {0, 1 + j, 1 + (j + 1) % count};
      const Corners of_one = {Vec3::Zero(), ring[i], ring[(i + 1) % count]};
      const Corners of_other = {Vec3::Zero(), ring[j], ring[(j + 1) % count]};
      EXPECT_TRUE(surely_apart({one, of_one}, {other, of_other}, margin_m)) << i << ' ' << j;
    }
  }
}

/// They cross along the x axis, and all of the one lies below a plane through the shared corner, its own or the other's
/// far side, by thousands of margins: how far a triangle may cross a plane by rounding goes with the margin.
TEST_F(TriangleSeparation, SmallTrianglesThatCrossAtACornerAreNotApart) {
  constexpr double size_m = 1e-4;
  const Corners one = {Vec3::Zero(), size_m * Vec3(1, 0, 0.2), size_m * Vec3(1, 0, -0.2)};
  const Corners other = {Vec3::Zero(), size_m * Vec3(2, 0.5, 0), size_m * Vec3(2, -0.5, 0)};
  EXPECT_FALSE(apart_in_any_order({0, 1, 2}, one, {0, 3, 4}, other));
}

}  // namespace
}  // namespace musclebench
