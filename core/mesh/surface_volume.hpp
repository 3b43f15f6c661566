#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Volume inside a closed surface by the divergence theorem, in m3; negative when it is wound inwards. Relative to the
/// first vertex, so that no digits are lost far from the origin.
inline double surface_volume_m3(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles) {
  if (positions.empty()) {
    return 0;
  }
  const Vec3& origin = positions.front();
  double six_volumes = 0;
  for (const Triangle& triangle : triangles) {
    const Vec3 a = positions[triangle[0]] - origin;
    six_volumes += a.dot((positions[triangle[1]] - origin).cross(positions[triangle[2]] - origin));
  }
  return six_volumes / 6;
}

}  // namespace musclebench
