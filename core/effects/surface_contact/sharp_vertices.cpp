#include "core/effects/surface_contact/sharp_vertices.hpp"

namespace musclebench {

namespace {

/// Sine of the least angle by which edges fall: of a bone as it is scanned a hundredth of the vertices.
constexpr double least_fall = 0.1;

}  // namespace

SharpVertices::SharpVertices(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  const auto corner = [&](const Triangle& triangle, std::size_t k) { return static_cast<std::size_t>(triangle[k]); };
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3& a = mesh.vertices[corner(triangle, 0)];
    const Vec3 area = (mesh.vertices[corner(triangle, 1)] - a).cross(mesh.vertices[corner(triangle, 2)] - a);
    for (std::size_t k = 0; k < 3; ++k) normals[corner(triangle, k)] += area;
  }
  for (Vec3& normal : normals) normal = normal.stableNormalized();
  std::vector<double> least(mesh.vertices.size(), 2);  // 2: of a vertex without edges
  for (const Triangle& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (const std::size_t other : {corner(triangle, (k + 1) % 3), corner(triangle, (k + 2) % 3)}) {
        const std::size_t at = corner(triangle, k);
        const Vec3 along = (mesh.vertices[at] - mesh.vertices[other]).stableNormalized();
        least[at] = std::min(least[at], along.dot(normals[at]));
      }
    }
  }
  for (std::size_t i = 0; i < least.size(); ++i) {
    if (least[i] > least_fall && least[i] <= 1) m_vertices.push_back({mesh.vertices[i], normals[i]});
  }
  std::ranges::stable_sort(m_vertices, {}, x_of);
}

}  // namespace musclebench
