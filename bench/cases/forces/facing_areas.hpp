#pragma once

#include <cstddef>
#include <span>

#include "core/mesh/triangle_mesh.hpp"
#include "core/mesh/triangles_at_vertices.hpp"

namespace musclebench {

/// The area about each vertex of a surface, as seen from what pushes it.
class FacingAreas {
 public:
  /// `triangles` outlive this.
  FacingAreas(std::size_t vertices, std::span<const Triangle> triangles);

  /// A third of the triangles about a vertex, as seen along the push on it, m2: those beside a rim do not count. At
  /// least a quarter of what they are from all sides. `positions_m` and `push` are in one frame.
  [[nodiscard]] double about_m2(int vertex, const Vec3& push, std::span<const Vec3> positions_m) const;

 private:
  std::span<const Triangle> m_triangles;
  TrianglesAtVertices m_around;
};

}  // namespace musclebench
