#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/distance/triangle_distance.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Angle-weighted pseudo-normals of a mesh's faces, edges and vertices (Baerentzen and Aanaes 2005, "Signed distance
/// computation using the angle weighted pseudonormal"). On a closed, manifold, consistently wound surface without
/// zero-area triangles (`RepairedMesh::clean`) a point is inside exactly where the pseudo-normal of its closest feature
/// points away from it. On other surfaces, or where two faces fold onto each other, the sign may be wrong.
class PseudoNormals {
 public:
  explicit PseudoNormals(const TriangleMesh& mesh);

  /// The pseudo-normal of a feature of a triangle. Not normalised; zero where the faces about the feature cancel.
  [[nodiscard]] Vec3 at(int triangle, Feature feature) const;

  /// Whether `point` is inside, given its closest point on the surface and the feature that contains it.
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

/// The same of a surface whose vertices move, computed on demand: contacts need few of them a step.
class MovingPseudoNormals {
 public:
  /// Of the mesh only the triangles are kept.
  explicit MovingPseudoNormals(const TriangleMesh& mesh);

  /// To the bit what `PseudoNormals` of a mesh with these `vertices` and the same triangles answers.
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
