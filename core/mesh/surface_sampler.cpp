#include "core/mesh/surface_sampler.hpp"

#include <algorithm>
#include <cassert>

namespace musclebench {

SurfaceSampler::SurfaceSampler(const TriangleMesh& mesh) : m_mesh(mesh) {
  double area = 0;
  m_area_until.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    area += (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm() / 2;
    m_area_until.push_back(area);
  }
  assert(area > 0);
}

SurfaceSample SurfaceSampler::draw(RandomNumbers& random) const {
  const double area = random.share() * m_area_until.back();
  // The first triangle whose cumulative area is larger, which a triangle without area never is.
  const auto found = std::upper_bound(m_area_until.begin(), m_area_until.end(), area);
  const auto triangle = static_cast<int>(std::min(found, m_area_until.end() - 1) - m_area_until.begin());
  const auto& [i, j, k] = m_mesh.triangles[triangle];
  const Vec3& a = m_mesh.vertices[i];
  const Vec3& b = m_mesh.vertices[j];
  const Vec3& c = m_mesh.vertices[k];
  const double v = random.share();
  const double w = random.share();
  return {point_of_triangle(a, b, c, v, w), (b - a).cross(c - a).stableNormalized(), triangle};
}

}  // namespace musclebench
