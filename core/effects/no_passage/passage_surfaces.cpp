#include "core/effects/no_passage/passage_surfaces.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace musclebench {

OwnedFeatures::OwnedFeatures(std::span<const Triangle> triangles, std::size_t vertices) : of(triangles.size()) {
  std::vector<char> has_owner(vertices, 0);
  struct Side {
    std::array<int, 2> edge;  ///< the smaller vertex first
    std::size_t triangle;
    std::size_t side;
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int vertex = triangles[t][k];
      const int next = triangles[t][(k + 1) % 3];
      if (std::exchange(has_owner[static_cast<std::size_t>(vertex)], 1) == 0) of[t].vertices[k] = vertex;
      sides.push_back({{std::min(vertex, next), std::max(vertex, next)}, t, k});
    }
  }
  std::ranges::stable_sort(sides, {}, &Side::edge);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (i > 0 && sides[i].edge == sides[i - 1].edge) continue;
    of[sides[i].triangle].edges[sides[i].side] = sides[i].edge;
  }
}

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
  const auto v = static_cast<std::size_t>(vertex);
  for (std::size_t i = m_first[v]; i < m_first[v + 1]; ++i) {
    const auto corner = [&](std::size_t k) { return at[static_cast<std::size_t>(triangles[m_triangles[i]][k])]; };
    const Vec3 origin = corner(0);
    visit(triangles[m_triangles[i]], Vec3((corner(1) - origin).cross(corner(2) - origin)));
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
