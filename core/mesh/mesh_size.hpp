#pragma once

#include <limits>
#include <span>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Axis-aligned bounding box of the points; empty for none.
Eigen::AlignedBox3d bounding_box(std::span<const Vec3> points);

/// Contains every point.
inline Eigen::AlignedBox3d unbounded_box() {
  const Vec3 infinite = Vec3::Constant(std::numeric_limits<double>::infinity());
  return {-infinite, infinite};
}

/// A point closer to the surface than this counts as on it and not as inside, because its side is decided by rounding.
/// (This includes faces inside the bone, where components overlap.) In metres: 1e-12 of the bounding box's diagonal.
double touching_distance_m(const TriangleMesh& mesh);

/// Square root of the triangles' mean area, in metres; 0 for none.
double mean_triangle_size_m(const TriangleMesh& mesh);

}  // namespace musclebench
