#include "core/geometry/coherent_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include <gtest/gtest.h>

#include "core/base/random_numbers.hpp"

namespace musclebench {
namespace {

double way_m(const std::vector<Vec3>& points, const std::vector<int>& order) {
  double sum = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    sum += (points[order[i]] - points[order[i - 1]]).norm();
  }
  return sum;
}

std::vector<int> numbers(int count) {
  std::vector<int> result(count);
  std::iota(result.begin(), result.end(), 0);
  return result;
}

/// Of a 16 x 16 x 16 grid, without order.
std::vector<Vec3> shuffled_grid() {
  std::vector<Vec3> positions;
  for (int i = 0; i < 4096; ++i) {
    positions.emplace_back(Vec3(i % 16, i / 16 % 16, i / 256) - Vec3(100, 0, 7));
  }
  RandomNumbers random(1);
  for (std::size_t i = positions.size() - 1; i > 0; --i) {
    std::swap(positions[i], positions[random.below(i + 1)]);
  }
  return positions;
}

TEST(CoherentOrder, LeadsFromNeighbourToNeighbour) {
  const std::vector<Vec3> points = shuffled_grid();
  const std::vector<int> order = coherent_order(points);
  std::vector<int> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, numbers(4096));
  EXPECT_LT(way_m(points, order), 2 * 4096);
  EXPECT_GT(way_m(points, numbers(4096)), 10 * 4096);
}

TEST(CoherentOrder, LeavesAShortWayAsItIs) {
  std::vector<Vec3> points;
  for (int i = 0; i < 1000; ++i) {
    points.emplace_back(std::cos(0.01 * i), std::sin(0.01 * i), 0.001 * i);
  }
  EXPECT_EQ(coherent_order(points), numbers(1000));
}

TEST(CoherentOrder, TakesAnyPoints) {
  std::vector<Vec3> points = shuffled_grid();
  points[0] = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  points[1] = Vec3::Constant(std::numeric_limits<double>::infinity());
  points[2] = Vec3::Constant(-1e300);
  for (const std::size_t count : {4096, 3, 2, 1, 0}) {
    std::vector<int> order = coherent_order(std::span(points).first(count));
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, numbers(static_cast<int>(count)));
  }
}

}  // namespace
}  // namespace musclebench
