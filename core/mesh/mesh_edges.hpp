#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// One side of a triangle as a use of an edge (a half-edge).
struct EdgeUse {
  int low = 0;           ///< the edge's smaller vertex index
  int high = 0;          ///< its larger one
  int corner = 0;        ///< 3 * triangle + k: the side runs from the triangle's corner k to corner (k + 1) % 3
  bool forward = false;  ///< it runs from `low` to `high`
};

/// All edges of a mesh with the triangles that use them, ordered by vertex indices. A side with two equal ends is left
/// out.
class MeshEdges {
 public:
  explicit MeshEdges(const TriangleMesh& mesh);

  [[nodiscard]] int count() const { return static_cast<int>(m_first.size()) - 1; }

  /// The uses of edge `edge`, by triangle.
  [[nodiscard]] std::span<const EdgeUse> uses(int edge) const {
    return {m_uses.data() + m_first[edge], static_cast<std::size_t>(m_first[edge + 1] - m_first[edge])};
  }

 private:
  std::vector<EdgeUse> m_uses;
  std::vector<int> m_first;  ///< by edge, index of its first use; and the number of uses
};

/// Edge index of each side (3 * triangle + k), -1 for a side that is no edge.
std::vector<int> edge_of_sides(const TriangleMesh& mesh, const MeshEdges& edges);

/// Disjoint sets (union-find) of 0 .. count-1; the smallest element represents a set.
class DisjointSets {
 public:
  explicit DisjointSets(int count);
  [[nodiscard]] int find(int element);
  /// Whether they were two sets.
  bool unite(int a, int b);

 private:
  std::vector<int> m_parent;
};

/// For each vertex the first vertex of its connected component, which may be itself; one that no triangle uses is a
/// component of its own.
std::vector<int> first_of_component(const TriangleMesh& mesh);

/// For each vertex the first vertex at exactly the same position, which may be itself.
std::vector<int> first_at_position(const std::vector<Vec3>& vertices);

/// The number of vertices around which the triangles form more than one fan (joined across shared edges).
int count_non_manifold_vertices(const TriangleMesh& mesh, const MeshEdges& edges);

/// Connected components across manifold edges (those of two triangles), and which triangles are wound against the
/// majority of their component.
struct Winding {
  std::vector<int> surface;   ///< by triangle, 0 .. surfaces-1
  std::vector<char> flipped;  ///< by triangle, 0 or 1
  int surfaces = 0;
};
Winding find_winding(const TriangleMesh& mesh, const MeshEdges& edges);

/// Whether a triangle has no area: two corners are one vertex, or its height is not distinguishable from 0 in double
/// precision.
bool is_flat(const TriangleMesh& mesh, const Triangle& triangle);

}  // namespace musclebench
