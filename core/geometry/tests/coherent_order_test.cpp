#include "core/geometry/coherent_order.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include "core/base/random_numbers.hpp"

namespace musclebench {
namespace {

double way_m(const std::vector<Vec3>& positions, const std::vector<int>& nodes, const std::vector<int>& order) {
  double sum = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    sum += (positions[nodes[order[i]]] - positions[nodes[order[i - 1]]]).norm();
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
  const std::vector<Vec3> positions = shuffled_grid();
  const std::vector<int> nodes = numbers(4096);
  const std::vector<int> order = coherent_order(positions, nodes);
  std::vector<int> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, nodes);
  EXPECT_LT(way_m(positions, nodes, order), 2 * 4096);
  EXPECT_GT(way_m(positions, nodes, nodes), 10 * 4096);
}

TEST(CoherentOrder, LeavesAShortWayAsItIs) {
  std::vector<Vec3> positions;
  std::vector<int> nodes;
  for (int i = 0; i < 1000; ++i) {
    positions.emplace_back(std::cos(0.01 * i), std::sin(0.01 * i), 0.001 * i);
    nodes.push_back(i);
  }
  EXPECT_EQ(coherent_order(positions, nodes), numbers(1000));
}

TEST(CoherentOrder, TakesAnyPositions) {
  std::vector<Vec3> positions = shuffled_grid();
  positions[3] = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  positions[5] = Vec3::Constant(std::numeric_limits<double>::infinity());
  positions[7] = Vec3::Constant(-1e300);
  for (const std::vector<int>& nodes : {numbers(4096), {3}, {3, 5}, {8, 8}, {}}) {
    std::vector<int> order = coherent_order(positions, nodes);
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, numbers(static_cast<int>(nodes.size())));
  }
}

}  // namespace
}  // namespace musclebench
