#pragma once

#include <span>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The smallest axis-parallel box about the points; empty for none.
Eigen::AlignedBox3d bounding_box(std::span<const Vec3> points);

/// A point closer to the surface than this lies on it, and so not inside: which side it is on is rounding. (Also on a
/// face that lies in the bone, where components overlap: there its depth, too, is the distance to that face.) In
/// metres; 1e-12 of the box's diagonal.
double touching_distance_m(const TriangleMesh& mesh);

/// Root of the mean area of the triangles, in metres; 0 for none.
double mean_triangle_size_m(const TriangleMesh& mesh);

}  // namespace musclebench
