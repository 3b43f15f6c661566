#include "core/measure/depth_histogram.hpp"

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

std::vector<Contact> contacts_of(const std::vector<double>& depths_m) {
  std::vector<Contact> contacts(depths_m.size());
  for (std::size_t i = 0; i < depths_m.size(); ++i) contacts[i].depth_m = depths_m[i];
  return contacts;
}

TEST(DepthHistogram, TellsThePercentileToItsClass) {
  std::vector<double> depths_m;
  for (int i = 1; i <= 1000; ++i) depths_m.push_back(1e-6 * i);
  DepthHistogram histogram;
  histogram.add(contacts_of(depths_m), 0);
  for (const double share : {0.1, 0.5, 0.99, 1.0}) {
    EXPECT_NEAR(*histogram.percentile(share), 1e-3 * share, 0.016e-3 * share) << share;
  }
}

TEST(DepthHistogram, CountsContactsThatAreNotInside) {
  DepthHistogram histogram;
  EXPECT_EQ(histogram.percentile(0.99), std::nullopt);
  histogram.add(contacts_of({1e-3, 1e-3}), 100);
  histogram.add({}, 99);
  EXPECT_NEAR(*histogram.percentile(0.99), 1e-3, 1.6e-5) << "2 of 199 are more than one in a hundred";
  histogram.add({}, 1);
  EXPECT_EQ(histogram.percentile(0.99), 0) << "2 of 200 are not";
}

TEST(DepthHistogram, TakesAnyDepth) {
  DepthHistogram histogram;
  histogram.add(contacts_of({0, 1e-300, 1e-18, 1e5, 1e300}), 0);
  EXPECT_GT(*histogram.percentile(1), 1e5);
  EXPECT_LT(*histogram.percentile(0.2), 1e-17);
}

}  // namespace
}  // namespace musclebench
