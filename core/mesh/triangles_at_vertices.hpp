#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Which triangles of a mesh a vertex is of. Functions are const and safe from several threads.
class TrianglesAtVertices {
 public:
  TrianglesAtVertices(std::span<const Triangle> triangles, std::size_t vertices);

  /// Their indices, ascending.
  [[nodiscard]] std::span<const std::size_t> of(int vertex) const {
    const auto v = static_cast<std::size_t>(vertex);
    return std::span(m_triangles).subspan(m_first[v], m_first[v + 1] - m_first[v]);
  }

  /// Unit normal by area of the triangles at a vertex, or 0. `at`: of all vertices.
  [[nodiscard]] Vec3 normal(int vertex, std::span<const Triangle> triangles, std::span<const Vec3> at) const;
  /// The most that the unit normal of such a triangle has along `direction`; -1 without any. With `other` of triangles
  /// that have this vertex, too: those of an edge.
  [[nodiscard]] double most_facing(int vertex, int other, std::span<const Triangle> triangles, std::span<const Vec3> at,
                                   const Vec3& direction) const;

 private:
  template <typename Visit>
  void for_each_normal(int vertex, std::span<const Triangle> triangles, std::span<const Vec3> at,
                       const Visit& visit) const;

  std::vector<std::size_t> m_first;  ///< by vertex, and one past the last
  std::vector<std::size_t> m_triangles;
};

}  // namespace musclebench
