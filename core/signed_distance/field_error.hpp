#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "core/signed_distance/signed_surface.hpp"

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

/// A field's value at a point in the frame of the surface, m; nothing where it has none.
using FieldValue = std::function<std::optional<double>(const Vec3& point)>;

/// Where a field is compared with the surface.
struct FieldErrorSamples {
  Eigen::AlignedBox3d box;  ///< points are drawn in it
  double reach_m = 0;       ///< and count up to this far from the surface
  int count = 0;
  std::uint64_t seed = 1;
};

/// Compares a field with the exact signed distance; deterministic.
FieldError estimate_error(const SignedSurface& surface, const FieldErrorSamples& wanted, const FieldValue& value);

}  // namespace musclebench
