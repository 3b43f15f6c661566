#include "core/measure/block_bootstrap.hpp"

#include <cmath>
#include <fstream>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// Numbers of a line after its first word; "nan" is one.
std::vector<double> numbers_of(const std::string& line) {
  std::istringstream words(line);
  std::vector<double> numbers;
  std::string word;
  for (words >> word; words >> word;) numbers.push_back(std::stod(word));
  return numbers;
}

TEST(BlockBootstrap, HasTheNumbersOfThePythonTools) {
  std::ifstream file(BLOCK_BOOTSTRAP_CASES);
  std::string name;
  std::vector<int> frames;
  std::vector<double> values;
  int cases = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("case ")) name = line;
    if (line.starts_with("frames ")) {
      const std::vector<double> numbers = numbers_of(line);
      frames.assign(numbers.begin(), numbers.end());
    }
    if (line.starts_with("values ")) values = numbers_of(line);
    if (!line.starts_with("median_low_high ")) continue;
    const std::vector<double> expected = numbers_of(line);
    const MedianEstimate found = block_bootstrap_median(frames, values);
    const auto is_same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
    EXPECT_EQ(found.median, expected[0]) << name;
    EXPECT_TRUE(is_same(found.low, expected[1])) << name << ": " << found.low << " for " << expected[1];
    EXPECT_TRUE(is_same(found.high, expected[2])) << name << ": " << found.high << " for " << expected[2];
    ++cases;
  }
  EXPECT_EQ(cases, 6);
}

TEST(BlockBootstrap, NeighboursThatAreAlikeCountAsOne) {
  std::vector<int> frames(400);
  std::iota(frames.begin(), frames.end(), 1);
  std::vector<double> alike(frames.size());
  std::vector<double> mixed(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    alike[i] = static_cast<double>((i / 10 * 17) % 40);
    mixed[i] = static_cast<double>((i * 17) % 40);
  }
  const MedianEstimate of_alike = block_bootstrap_median(frames, alike);
  const MedianEstimate of_mixed = block_bootstrap_median(frames, mixed);
  EXPECT_LT(of_alike.low, of_alike.median);
  EXPECT_GT(of_alike.high - of_alike.low, 2 * (of_mixed.high - of_mixed.low));
}

}  // namespace
}  // namespace musclebench
