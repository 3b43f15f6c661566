#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/percentile.hpp"
#include "core/contact/contact.hpp"

namespace musclebench {

/// The smallest error of signed distance that a backend's answer about one point and one bone admits, in metres.
/// `signed_distance_m` is the true one; `answer` the contact, or nullptr where none was reported; without `has_depth`
/// (`Capabilities::depth`) a contact only says that the point is inside, as no contact says that it is not.
inline double depth_error_m(double signed_distance_m, const Contact* answer, bool has_depth) {
  if (answer == nullptr) {
    return std::max(0.0, -signed_distance_m);
  }
  return has_depth ? std::abs(-answer->depth_m - signed_distance_m) : std::max(0.0, signed_distance_m);
}

/// Statistics over a set of errors; all 0 where there is none.
struct ErrorStatistics {
  double max = 0;
  double p99 = 0;  ///< see percentile_index
  double mean = 0;
  double rms = 0;
};

inline ErrorStatistics error_statistics(std::vector<double> errors) {
  ErrorStatistics result;
  if (errors.empty()) {
    return result;
  }
  // Ascending, so that the sums do not depend on the order in which the errors came.
  std::sort(errors.begin(), errors.end());
  const auto count = static_cast<double>(errors.size());
  for (const double error : errors) {
    result.mean += error / count;
    result.rms += error * error / count;
  }
  result.rms = std::sqrt(result.rms);
  result.max = errors.back();
  result.p99 = errors[percentile_index(errors.size(), 0.99)];
  return result;
}

}  // namespace musclebench
