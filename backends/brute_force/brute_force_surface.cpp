#include "backends/brute_force/brute_force_surface.hpp"

#include <cmath>
#include <limits>

#include "core/distance/triangle_distance.hpp"
#include "core/distance/winding_number.hpp"

namespace musclebench {

SurfacePoint locate_by_brute_force(const TriangleMesh& mesh, const Vec3& point) {
  ClosestOnTriangle closest;
  closest.squared_distance_m2 = std::numeric_limits<double>::infinity();
  Vec3 face_normal = Vec3::UnitZ();
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3& a = mesh.vertices[triangle[0]];
    const Vec3& b = mesh.vertices[triangle[1]];
    const Vec3& c = mesh.vertices[triangle[2]];
    const ClosestOnTriangle candidate = closest_on_triangle(point, a, b, c);
    if (candidate.squared_distance_m2 < closest.squared_distance_m2) {
      closest = candidate;
      face_normal = (b - a).cross(c - a);
    }
  }
  SurfacePoint result;
  result.inside = winding_number(mesh.triangles, mesh.vertices, point) > 0.5;
  result.distance_m = std::sqrt(closest.squared_distance_m2);
  const Vec3 to_closest = closest.point - point;
  const double length = to_closest.norm();
  // On the surface the direction to the closest point is only rounding; the face's normal is not.
  if (length > 1e-12 * closest.point.cwiseAbs().maxCoeff()) {
    result.normal = (result.inside ? 1.0 : -1.0) / length * to_closest;
  } else if (const double norm = face_normal.norm(); norm > 0) {
    result.normal = face_normal / norm;
  } else {
    result.normal = Vec3::UnitZ();
  }
  return result;
}

}  // namespace musclebench
