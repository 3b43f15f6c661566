#pragma once

#include <limits>
#include <span>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The axis-aligned bounding box of the points, in metres. Empty if there are no points.
Eigen::AlignedBox3d bounding_box(std::span<const Vec3> points);

/// A box that contains every point.
inline Eigen::AlignedBox3d unbounded_box() {
  const Vec3 infinite = Vec3::Constant(std::numeric_limits<double>::infinity());
  return {-infinite, infinite};
}

/// The distance in metres below which a point counts as on the surface, hence outside: rounding decides its side. It is
/// 1e-12 of the diagonal of the bounding box. It also applies to faces inside a bone, where components overlap.
double touching_distance_m(const TriangleMesh& mesh);

/// The sum of the areas of the triangles, in square metres.
double surface_area_m2(const TriangleMesh& mesh);

/// The square root of the mean area of the triangles, in metres. 0 if there are no triangles.
double mean_triangle_size_m(const TriangleMesh& mesh);

}  // namespace musclebench
