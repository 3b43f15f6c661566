#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Side, distance and normal of a point with respect to a surface.
struct SurfacePoint {
  bool inside = false;
  double distance_m = 0;
  Vec3 normal = Vec3::Zero();  ///< outward, unit
};

/// By definition: the closest of all triangles; inside where their solid angles sum to more than 2 pi (winding number
/// above 0.5). `mesh` has triangles, `point` is finite; both in metres, in one frame.
SurfacePoint locate_by_brute_force(const TriangleMesh& mesh, const Vec3& point);

}  // namespace musclebench
