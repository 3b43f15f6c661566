#pragma once

#include <algorithm>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The vertices of a surface at which it comes to a point, all edges falling away from the vertex's normal: where a
/// bone can poke through a face between any points at which that is looked at.
class SharpVertices {
 public:
  struct Vertex {
    Vec3 position;  ///< m, in the mesh's frame
    Vec3 normal;    ///< unit
  };

  explicit SharpVertices(const TriangleMesh& mesh);

  /// Calls `visit(vertex)` with each in the box.
  template <typename Visit>
  void for_each_in(const Eigen::AlignedBox3d& box, const Visit& visit) const {
    auto vertex = std::ranges::lower_bound(m_vertices, box.min().x(), {}, x_of);
    for (; vertex != m_vertices.end() && x_of(*vertex) <= box.max().x(); ++vertex) {
      if (box.contains(vertex->position)) visit(*vertex);
    }
  }

 private:
  static double x_of(const Vertex& vertex) { return vertex.position.x(); }

  std::vector<Vertex> m_vertices;  ///< ascending in x
};

}  // namespace musclebench
