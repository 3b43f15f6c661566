#include "bench/results/summary.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace musclebench {

std::string median_ms(std::vector<Nanoseconds> values) {
  if (values.empty()) {
    return "unknown (warm-up only)";
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return fmt::format("{:10.3f} ms", static_cast<double>(*middle) * 1e-6);
}

}  // namespace musclebench
