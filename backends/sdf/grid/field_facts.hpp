#pragma once

#include <cstdint>
#include <limits>

namespace musclebench {

/// How far a field is from the exact distance, at random points near the surface.
struct FieldError {
  std::int32_t samples = 0;
  std::int32_t wrong_signs = 0;  ///< samples where the field has the wrong sign
  double largest_m = 0;
  double p99_m = 0;
  double mean_m = 0;
  double deepest_wrong_sign_m = 0;  ///< largest exact distance of those
};

/// Bounds and error of a field, computed when it is built and stored with it.
struct FieldFacts {
  /// |value(a) - value(b)| <= lipschitz_bound |a - b| as long as the path from a to b stays where the field has
  /// coefficients.
  double lipschitz_bound = std::numeric_limits<double>::infinity();
  /// Outside the bone and farther than this from its surface the field is not negative.
  double sign_error_distance_m = std::numeric_limits<double>::infinity();
  FieldError error;
};

}  // namespace musclebench
