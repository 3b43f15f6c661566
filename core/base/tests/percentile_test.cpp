#include "core/base/percentile.hpp"

#include <numeric>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

TEST(Percentile, IsTheNearestRank) {
  for (std::size_t count = 1; count <= 2000; ++count) {
    EXPECT_EQ(percentile_index(count, 0.99), (99 * count + 99) / 100 - 1) << count;
    EXPECT_EQ(percentile_index(count, 0.5), (count + 1) / 2 - 1) << count;
  }
  EXPECT_EQ(percentile_index(7, 0), 0U);
  EXPECT_EQ(percentile_index(7, 1), 6U);
}

TEST(Percentile, OfValuesInAnyOrder) {
  std::vector<int> values(200);
  std::iota(values.rbegin(), values.rend(), 1);
  EXPECT_EQ(percentile(values, 0.99), 198);
  EXPECT_EQ(percentile(std::vector{3.5}, 0.99), 3.5);
}

TEST(Median, OfAnEvenNumberIsTheMeanOfTheTwoInTheMiddle) {
  EXPECT_EQ(median(std::vector{5, 1, 3}), 3);
  EXPECT_EQ(median(std::vector{4, 1, 10, 3}), 3.5);
  EXPECT_EQ(median(std::vector{7}), 7);
}

}  // namespace
}  // namespace musclebench
