#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <vector>

namespace musclebench {

/// Index of a percentile among `count` > 0 ascending values, by nearest rank: the ceil(share * count)-th smallest, the
/// first for a share of 0. A percentile is thus always one of the values: nothing is interpolated.
inline std::size_t percentile_index(std::size_t count, double share) {
  assert(count > 0 && share >= 0 && share <= 1);
  // 0.99 * 700 is 693.0000000000001 or so; a share of a rank never matters.
  const double rank = std::ceil(share * static_cast<double>(count) - 1e-6);
  return std::min(static_cast<std::size_t>(std::max(rank, 1.0)), count) - 1;
}

/// The percentile `share` (0.99: the 99th) of `values`, at least one, in any order.
template <typename Value>
Value percentile(std::vector<Value> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(percentile_index(values.size(), share));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The middle one of `values`, at least one, in any order; of an even number the mean of the two in the middle.
template <typename Value>
double median(std::vector<Value> values) {
  assert(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  const auto upper = static_cast<double>(*middle);
  if (values.size() % 2 == 1) return upper;
  return 0.5 * (static_cast<double>(*std::max_element(values.begin(), middle)) + upper);
}

}  // namespace musclebench
