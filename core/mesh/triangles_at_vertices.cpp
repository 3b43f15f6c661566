#include "core/mesh/triangles_at_vertices.hpp"

#include <algorithm>
#include <numeric>

namespace musclebench {

TrianglesAtVertices::TrianglesAtVertices(std::span<const Triangle> triangles, std::size_t vertices)
    : m_first(vertices + 1, 0), m_triangles(3 * triangles.size()) {
  for (const Triangle& triangle : triangles) {
    for (const int vertex : triangle) ++m_first[static_cast<std::size_t>(vertex) + 1];
  }
  std::partial_sum(m_first.begin(), m_first.end(), m_first.begin());
  std::vector<std::size_t> next(m_first.begin(), m_first.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const int vertex : triangles[t]) m_triangles[next[static_cast<std::size_t>(vertex)]++] = t;
  }
}

/// With the normals by area, not unit.
template <typename Visit>
void TrianglesAtVertices::for_each_normal(int vertex, std::span<const Triangle> triangles, std::span<const Vec3> at,
                                          const Visit& visit) const {
  for (const std::size_t t : of(vertex)) {
    const auto corner = [&](std::size_t k) { return at[static_cast<std::size_t>(triangles[t][k])]; };
    const Vec3 origin = corner(0);
    visit(triangles[t], Vec3((corner(1) - origin).cross(corner(2) - origin)));
  }
}

Vec3 TrianglesAtVertices::normal(int vertex, std::span<const Triangle> triangles, std::span<const Vec3> at) const {
  Vec3 sum = Vec3::Zero();
  for_each_normal(vertex, triangles, at, [&](const Triangle&, const Vec3& normal) { sum += normal; });
  return sum.stableNormalized();
}

double TrianglesAtVertices::most_facing(int vertex, int other, std::span<const Triangle> triangles,
                                        std::span<const Vec3> at, const Vec3& direction) const {
  double most = -1;
  for_each_normal(vertex, triangles, at, [&](const Triangle& triangle, const Vec3& normal) {
    if (std::ranges::find(triangle, other) == triangle.end()) return;
    most = std::max(most, normal.stableNormalized().dot(direction));
  });
  return most;
}

}  // namespace musclebench
