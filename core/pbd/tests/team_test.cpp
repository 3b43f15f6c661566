#include "core/pbd/team.hpp"

#include <array>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/pbd/node_order.hpp"

namespace musclebench {
namespace {

TEST(Team, SharesMakeUpTheWhole) {
  const std::vector<int> rows_of_entries = {0, 0, 3, 4, 4, 9, 30, 31, 31, 77};
  for (const int threads : {1, 2, 3, 8, 20}) {
    Barrier barrier(threads);
    for (const std::size_t count : {0U, 1U, 7U, 78U}) {
      std::size_t next = 0;
      std::size_t next_entry = 0;
      for (int thread = 0; thread < threads; ++thread) {
        const Team team(thread, threads, barrier);
        const auto [first, last] = team.share(count);
        EXPECT_EQ(first, next);
        next = last;
        if (count != 78) continue;
        const Team::Share entries =
            team.share_by_row(rows_of_entries.size(), count, [&](std::size_t i) { return rows_of_entries[i]; });
        EXPECT_EQ(entries.first, next_entry);
        next_entry = entries.last;
        for (std::size_t i = entries.first; i < entries.last; ++i) {
          EXPECT_GE(rows_of_entries[i], static_cast<int>(first));
          EXPECT_LT(rows_of_entries[i], static_cast<int>(last));
        }
      }
      EXPECT_EQ(next, count);
      EXPECT_EQ(next_entry, count == 78 ? rows_of_entries.size() : 0);
    }
  }
}

/// Every thread adds to a sum of its own and reads those of the others after each wait.
TEST(Barrier, NobodyGoesOnBeforeAllAreThere) {
  constexpr int threads = 5;  // more than this machine may have cores
  constexpr int rounds = 300;
  Barrier barrier(threads);
  std::array<int, threads> sums{};
  std::array<int, threads> seen_wrong{};
  std::vector<std::thread> team;
  for (int thread = 0; thread < threads; ++thread) {
    team.emplace_back([&, thread] {
      const Team member(thread, threads, barrier);
      for (int round = 1; round <= rounds; ++round) {
        ++sums[thread];
        member.wait();
        for (const int sum : sums) seen_wrong[thread] += sum == round ? 0 : 1;
        member.wait();
      }
    });
  }
  for (std::thread& thread : team) thread.join();
  EXPECT_EQ(seen_wrong, (std::array<int, threads>{}));
}

TEST(Barrier, SpinsWhereThereAreCoresForAllOrNobodyKnows) {
  EXPECT_GT(Barrier::spins(2, 2), 0);
  EXPECT_EQ(Barrier::spins(3, 2), 0);
  EXPECT_EQ(Barrier::spins(3, 0), Barrier::spins(2, 2));
}

TEST(NodeOrder, RunsAlongTheLongestSide) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec3> positions;
  for (int i = 0; i < 500; ++i) {
    positions.emplace_back(unit(random), 3 * unit(random), 2 * unit(random));
  }
  const std::vector<Body> bodies = {{"a", 0, 500}};
  const NodeOrder order(positions, bodies);
  ASSERT_EQ(order.size(), positions.size());
  for (std::size_t row = 0; row < order.size(); ++row) {
    EXPECT_EQ(order.row_of(order.node_in(row)), static_cast<int>(row));
    EXPECT_LE(positions[order.node_in(row == 0 ? 0 : row - 1)].y(), positions[order.node_in(row)].y());
  }
  EXPECT_EQ(NodeOrder(std::vector<Vec3>(), {}).size(), 0U);
  const std::vector<Body> two = {{"a", 0, 200}, {"b", 200, 500}};
  const NodeOrder order_of_two(positions, two);
  for (int node = 0; node < 500; ++node) {
    EXPECT_EQ(order_of_two.row_of(node) < 200, node < 200) << node;
    EXPECT_EQ(body_of(two, node), node < 200 ? 0U : 1U) << node;
  }
}

}  // namespace
}  // namespace musclebench
