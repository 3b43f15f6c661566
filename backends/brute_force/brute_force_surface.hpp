#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Where a point stands to a surface.
struct SurfacePoint {
  bool inside = false;
  double distance_m = 0;
  Vec3 normal = Vec3::Zero();  ///< outward, unit
};

/// By definition: the closest of all triangles; inside where the solid angles of all of them sum to more than half a
/// sphere (winding number above 0.5). `mesh` has triangles, `point` is finite.
SurfacePoint locate_by_brute_force(const TriangleMesh& mesh, const Vec3& point);

}  // namespace musclebench
