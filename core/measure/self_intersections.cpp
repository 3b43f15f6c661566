#include "core/measure/self_intersections.hpp"

#include <algorithm>
#include <vector>

#include "core/bvh/triangle_bvh.hpp"
#include "core/referee/referee_sign.hpp"

namespace musclebench {
namespace {

class TrianglePair {
 public:
  TrianglePair(const TriangleMesh& mesh, const Triangle& one, const Triangle& other)
      : m_mesh(mesh), m_one(one), m_other(other) {}

  [[nodiscard]] bool intersect() const {
    const auto shared = std::count_if(m_one.begin(), m_one.end(), [&](int vertex) { return has(m_other, vertex); });
    return shared < 2 && (an_edge_crosses(m_one, m_other) || an_edge_crosses(m_other, m_one));
  }

 private:
  static bool has(const Triangle& triangle, int vertex) {
    return std::find(triangle.begin(), triangle.end(), vertex) != triangle.end();
  }
  [[nodiscard]] const Vec3& at(int vertex) const { return m_mesh.vertices[static_cast<std::size_t>(vertex)]; }

  /// Edges with an end in the other triangle's corner meet it there and nowhere else, unless they lie in its plane.
  [[nodiscard]] bool an_edge_crosses(const Triangle& edges, const Triangle& face) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = edges[k];
      const int to = edges[(k + 1) % 3];
      if (has(face, from) || has(face, to)) continue;
      if (segment_crossing(at(face[0]), at(face[1]), at(face[2]), at(from), at(to)) != 0) return true;
    }
    return false;
  }

  const TriangleMesh& m_mesh;
  const Triangle& m_one;
  const Triangle& m_other;
};

}  // namespace

int count_self_intersecting_triangles(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return 0;
  std::vector<char> intersecting(mesh.triangles.size(), 0);
  TriangleBvh(mesh).for_each_close_pair([&](int one, int other) {
    const auto i = static_cast<std::size_t>(one);
    const auto j = static_cast<std::size_t>(other);
    if (intersecting[i] != 0 && intersecting[j] != 0) return;
    if (TrianglePair(mesh, mesh.triangles[i], mesh.triangles[j]).intersect()) intersecting[i] = intersecting[j] = 1;
  });
  return static_cast<int>(std::count(intersecting.begin(), intersecting.end(), 1));
}

}  // namespace musclebench
