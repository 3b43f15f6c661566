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

double mean_triangle_size_m(const TriangleMesh& mesh) {
  double area = 0;
  for (const Triangle& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(triangle[i])]; };
    area += 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
  }
  return mesh.triangles.empty() ? 0 : std::sqrt(area / static_cast<double>(mesh.triangles.size()));
}

}  // namespace musclebench
