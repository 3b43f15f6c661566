#pragma once

#include <cmath>

#include "backends/sdf/grid/field_block.hpp"
#include "backends/sdf/grid/grid_shape.hpp"
#include "core/contact/contact.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// Unit contact normal for this gradient of the field; where the gradient vanishes, away from the middle of the field,
/// and in that very middle along x.
inline Vec3 outward(const Vec3& gradient, const Vec3& from_middle) {
  for (const Vec3& direction : {gradient, from_middle}) {
    const double length = direction.norm();
    if (length > 1e-9 && std::isfinite(length)) {
      return direction / length;
    }
  }
  return Vec3::UnitX();
}

/// The contact of the block's point `n`, where the field over `grid` is negative; `pose`: of the bone.
inline Contact field_contact(const GridShape& grid, const RigidMotion& pose, int bone, int node,
                             const FieldBlock& block, std::size_t n) {
  const Vec3 from_middle = grid.point(block.cells(n)) - 0.5 * (grid.lower_m + grid.upper_m());
  return {node, bone, -block.value_m[n], pose.apply_to_direction(outward(block.slope(n), from_middle))};
}

}  // namespace musclebench
