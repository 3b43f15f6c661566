#include "core/mesh/split_mesh.hpp"

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/mesh_edges.hpp"

namespace musclebench {

namespace {

/// `middle_of(a, b)`: between two vertices, a < b.
template <typename MiddleOf>
void split_once(TriangleMesh& mesh, const MiddleOf& middle_of) {
  const MeshEdges edges(mesh);
  const std::vector<int> edge_of_side = edge_of_sides(mesh, edges);
  std::vector<int> middle_of_edge(static_cast<std::size_t>(edges.count()), -1);
  mesh.vertices.reserve(mesh.vertices.size() + middle_of_edge.size());
  std::vector<Triangle> split;
  split.reserve(4 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    // A side from a vertex to itself has no middle but the vertex.
    const auto middle = [&](std::size_t side, int vertex) {
      const int edge = edge_of_side[3 * t + side];
      if (edge < 0) return vertex;
      int& found = middle_of_edge[edge];
      if (found < 0) {
        const EdgeUse& use = edges.uses(edge).front();
        const Vec3 between = middle_of(use.low, use.high);
        found = static_cast<int>(mesh.vertices.size());
        mesh.vertices.push_back(between);
      }
      return found;
    };
    const int ab = middle(0, a);
    const int bc = middle(1, b);
    const int ca = middle(2, c);
    split.insert(split.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  mesh.triangles = std::move(split);
}

/// Of each vertex, unit; zero where it has none.
std::vector<Vec3> smooth_normals(const TriangleMesh& mesh) {
  constexpr double least_cosine = 0.5;
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  std::vector<Vec3> of_triangle;
  of_triangle.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    Vec3 normal = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& corner = mesh.vertices[triangle[i]];
      const Vec3 next = mesh.vertices[triangle[(i + 1) % 3]] - corner;
      const Vec3 last = mesh.vertices[triangle[(i + 2) % 3]] - corner;
      normal = next.cross(last);
      const double lengths2 = next.squaredNorm() * last.squaredNorm();
      if (lengths2 > 0) normals[triangle[i]] += normal / lengths2;
    }
    of_triangle.push_back(normal.normalized());
  }
  for (Vec3& normal : normals) normal.normalize();
  const MeshEdges edges(mesh);
  for (int edge = 0; edge < edges.count(); ++edge) {
    const std::span<const EdgeUse> uses = edges.uses(edge);
    if (uses.size() == 2 && uses[0].forward != uses[1].forward &&
        of_triangle[uses[0].corner / 3].dot(of_triangle[uses[1].corner / 3]) >= least_cosine) {
      continue;
    }
    normals[uses[0].low] = normals[uses[0].high] = Vec3::Zero();
  }
  return normals;
}

}  // namespace

TriangleMesh split_flat(TriangleMesh mesh, int times) {
  for (int i = 0; i < times; ++i) {
    split_once(mesh, [&](int a, int b) { return Vec3(0.5 * (mesh.vertices[a] + mesh.vertices[b])); });
  }
  return mesh;
}

TriangleMesh split_curved(TriangleMesh mesh, int times) {
  for (int i = 0; i < times; ++i) {
    const std::vector<Vec3> normals = smooth_normals(mesh);
    split_once(mesh, [&](int a, int b) {
      const Vec3 side = mesh.vertices[b] - mesh.vertices[a];
      // The inner control points of the cubic lie in the tangent planes of the two ends.
      return Vec3(0.5 * (mesh.vertices[a] + mesh.vertices[b]) -
                  0.125 * (side.dot(normals[a]) * normals[a] - side.dot(normals[b]) * normals[b]));
    });
  }
  return mesh;
}

}  // namespace musclebench
