#pragma once

#include <cstddef>
#include <vector>

#include "core/distance/triangle_distance.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Angle-weighted pseudo-normals of a mesh's faces, edges and vertices (Baerentzen and Aanaes 2005, Signed distance
/// computation using the angle weighted pseudonormal). On a closed, manifold, consistently wound surface without
/// zero-area triangles a point is inside exactly where the pseudo-normal of its closest feature points away from it
/// (`RepairedMesh::clean`); on other surfaces, or where two faces fold onto each other, the answer may be wrong.
class PseudoNormals {
 public:
  explicit PseudoNormals(const TriangleMesh& mesh);

  /// Of a feature of a triangle; not of unit length, zero where the faces about it cancel.
  [[nodiscard]] Vec3 at(int triangle, Feature feature) const;

  /// Whether `point` lies on the inner side, seen from its closest point on the surface.
  [[nodiscard]] bool is_inside(const Vec3& point, const Vec3& closest, int triangle, Feature feature) const {
    return (point - closest).dot(at(triangle, feature)) < 0;
  }

  [[nodiscard]] std::size_t bytes() const {
    return m_triangles.capacity() * sizeof(Triangle) + (m_of_face.capacity() + m_of_vertex.capacity()) * sizeof(Vec3) +
           m_neighbour.capacity() * sizeof(int);
  }

 private:
  std::vector<Triangle> m_triangles;
  std::vector<Vec3> m_of_face;
  std::vector<Vec3> m_of_vertex;
  std::vector<int> m_neighbour;  ///< of edge 3 t + i: a triangle's index, or -1; the edge's normal is the sum of both
};

}  // namespace musclebench
