#pragma once

#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

#include "core/distance/triangle_distance.hpp"
#include "core/mesh/tests/random_points.hpp"
#include "core/mesh/triangle_mesh.hpp"

// What tests of trees hold answers against: sums over all triangles, without a tree.
namespace musclebench {

inline const Vec3& corner(const TriangleMesh& mesh, const Triangle& triangle, std::size_t i) {
  return mesh.vertices[static_cast<std::size_t>(triangle[i])];
}

inline ClosestOnTriangle closest_on(const TriangleMesh& mesh, int triangle, const Vec3& point) {
  const Triangle& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  return closest_on_triangle(point, corner(mesh, t, 0), corner(mesh, t, 1), corner(mesh, t, 2));
}

inline double exact_winding(const TriangleMesh& mesh, const Vec3& point) {
  double angle = 0;
  for (const Triangle& t : mesh.triangles) {
    angle += solid_angle(point, corner(mesh, t, 0), corner(mesh, t, 1), corner(mesh, t, 2));
  }
  return angle / (4 * std::numbers::pi);
}

}  // namespace musclebench
