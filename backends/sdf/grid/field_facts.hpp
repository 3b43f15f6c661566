#pragma once

#include <limits>

#include "core/signed_distance/field_error.hpp"

namespace musclebench {

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
