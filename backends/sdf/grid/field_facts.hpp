#pragma once

#include <limits>

#include "core/signed_distance/field_error.hpp"

namespace musclebench {

/// Bounds and error of a field, computed when it is built and stored with it.
struct FieldFacts {
  /// |value(a) - value(b)| <= lipschitz_bound |a - b| as long as the path from a to b stays where the
  /// grid answers.
  double lipschitz_bound = std::numeric_limits<double>::infinity();
  FieldError error;
};

}  // namespace musclebench
