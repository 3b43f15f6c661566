#pragma once

#include <span>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Volume inside a closed surface by the divergence theorem, in m3; negative when it is wound inwards. Relative to
/// `origin`, which is near, so that no digits are lost far from that of the world.
inline double surface_volume_m3(std::span<const Vec3> positions, std::span<const Triangle> triangles,
                                const Vec3& origin) {
  double six_volumes = 0;
  for (const Triangle& triangle : triangles) {
    const Vec3 a = positions[triangle[0]] - origin;
    six_volumes += a.dot((positions[triangle[1]] - origin).cross(positions[triangle[2]] - origin));
  }
  return six_volumes / 6;
}

/// The same relative to the first vertex.
inline double surface_volume_m3(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  return positions.empty() ? 0 : surface_volume_m3(positions, triangles, positions.front());
}

}  // namespace musclebench
