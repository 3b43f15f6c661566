#include "core/mesh/mesh_size.hpp"

#include <cmath>

namespace musclebench {

Eigen::AlignedBox3d bounding_box(std::span<const Vec3> points) {
  Eigen::AlignedBox3d box;
  for (const Vec3& point : points) {
    box.extend(point);
  }
  return box;
}

double touching_distance_m(const TriangleMesh& mesh) {
  constexpr double share = 1e-12;
  const Eigen::AlignedBox3d box = bounding_box(mesh.vertices);
  return box.isEmpty() ? 0 : share * box.diagonal().norm();
}

double surface_area_m2(const TriangleMesh& mesh) {
  double area_m2 = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3& corner = mesh.vertices[a];
    area_m2 += 0.5 * (mesh.vertices[b] - corner).cross(mesh.vertices[c] - corner).norm();
  }
  return area_m2;
}

double mean_triangle_size_m(const TriangleMesh& mesh) {
  return mesh.triangles.empty() ? 0 : std::sqrt(surface_area_m2(mesh) / static_cast<double>(mesh.triangles.size()));
}

}  // namespace musclebench
