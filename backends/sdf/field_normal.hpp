#pragma once

#include <cmath>

#include "core/geometry/triangle_mesh.hpp"

namespace musclebench {

/// The unit vector that leads out of a bone where its field has this gradient: away from the middle of the field where
/// the field is flat, and along x in that very middle.
inline Vec3 outward(const Vec3& gradient, const Vec3& from_middle) {
  for (const Vec3& direction : {gradient, from_middle}) {
    const double length = direction.norm();
    if (length > 1e-9 && std::isfinite(length)) {
      return direction / length;
    }
  }
  return Vec3::UnitX();
}

}  // namespace musclebench
