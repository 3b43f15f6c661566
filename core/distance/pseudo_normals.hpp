#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/distance/triangle_distance.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Angle-weighted pseudo-normals of the faces, edges and vertices of a mesh. They give the side of a point from its
/// closest feature. Source: Baerentzen and Aanaes 2005, "Signed distance computation using the angle weighted
/// pseudonormal".
/// The sign is right for a clean mesh (`RepairedMesh::clean`). It may be wrong for other meshes, and where two faces
/// fold onto each other. Queries are safe from several threads.
class PseudoNormals {
 public:
  explicit PseudoNormals(const TriangleMesh& mesh);

  /// The outward pseudo-normal of a feature of a triangle. It is not normalised. It is zero if the faces around the
  /// feature cancel.
  [[nodiscard]] Vec3 at(int triangle, Feature feature) const;

  /// Whether `point` is inside. `closest` is its closest point on the surface, `feature` of `triangle` contains it.
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
  std::vector<int> m_neighbour;  ///< across edge 3 t + i: a triangle, or -1; the edge's normal is the sum of both
};

/// The same pseudo-normals for a surface whose vertices move. Each is computed when it is asked for, because contacts
/// need only a few in each step. Queries are safe from several threads.
class MovingPseudoNormals {
 public:
  /// Copies the triangles of the mesh and ignores its vertices.
  explicit MovingPseudoNormals(const TriangleMesh& mesh);

  /// The same bits as `PseudoNormals::at` for a mesh with these `vertices`.
  [[nodiscard]] Vec3 at(std::span<const Vec3> vertices, int triangle, Feature feature) const;

  [[nodiscard]] std::size_t bytes() const {
    return m_triangles.capacity() * sizeof(Triangle) +
           (m_neighbour.capacity() + m_first_side.capacity() + m_sides.capacity()) * sizeof(int);
  }

 private:
  std::vector<Triangle> m_triangles;
  std::vector<int> m_neighbour;   ///< as in PseudoNormals
  std::vector<int> m_first_side;  ///< by vertex: of its part of m_sides; and the number of all
  std::vector<int> m_sides;       ///< 3 t + i for a triangle whose corner i the vertex is, ascending
};

}  // namespace musclebench
