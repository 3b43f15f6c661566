#include "core/mesh_repair/doubled_triangles.hpp"

#include <algorithm>
#include <vector>

#include "core/mesh_repair/merge_vertices.hpp"

namespace musclebench {

namespace {

bool is_same_winding(const Triangle& a, const Triangle& b) {
  const auto start = std::find(b.begin(), b.end(), a[0]) - b.begin();
  return b[(start + 1) % 3] == a[1];
}

/// Triangles of the same three vertices, as lists of their indices in rising order. They meet at each of their edges,
/// so it is enough to look at the edge that does not contain the largest vertex.
std::vector<std::vector<int>> coincident_triangles(const TriangleMesh& mesh, const MeshEdges& edges) {
  std::vector<std::vector<int>> groups;
  std::vector<std::pair<int, int>> across;  // opposite vertex, triangle
  for (int edge = 0; edge < edges.count(); ++edge) {
    across.clear();
    for (const EdgeUse& use : edges.uses(edge)) {
      const int triangle = use.corner / 3;
      const int opposite = mesh.triangles[triangle][(use.corner + 2) % 3];
      if (opposite > use.high) across.emplace_back(opposite, triangle);
    }
    std::sort(across.begin(), across.end());
    for (std::size_t i = 1; i < across.size(); ++i) {
      if (across[i].first != across[i - 1].first) continue;
      if (groups.empty() || groups.back().back() != across[i - 1].second) groups.push_back({across[i - 1].second});
      groups.back().push_back(across[i].second);
    }
  }
  return groups;
}

class DoubledTriangles {
 public:
  DoubledTriangles(TriangleMesh& mesh, const MeshEdges& edges)
      : m_mesh(mesh),
        m_edges(edges),
        m_edge_of_side(edge_of_sides(mesh, m_edges)),
        m_uses(m_edges.count()),
        m_is_dropped(mesh.triangles.size(), 0),
        m_partner(mesh.triangles.size(), -1) {
    for (int edge = 0; edge < m_edges.count(); ++edge) {
      m_uses[edge] = static_cast<int>(m_edges.uses(edge).size());
    }
  }

  int drop(std::vector<std::vector<int>> groups) {
    std::vector<int> waiting;
    for (std::vector<int>& group : groups) {
      reduce_to_one_or_two(group);
      if (group.size() == 2) {
        m_partner[group[0]] = group[1];
        m_partner[group[1]] = group[0];
        waiting.push_back(group[0]);
      }
    }
    std::reverse(waiting.begin(), waiting.end());
    // A drop makes the edges of a doubled neighbour odd: the whole of a doubled patch follows from its rim.
    while (!waiting.empty()) {
      const int first = waiting.back();
      waiting.pop_back();
      if (m_partner[first] >= 0 && is_one_too_many(first)) {
        const int second = m_partner[first];
        m_partner[first] = m_partner[second] = -1;
        mark(second);
        for (int k = 0; k < 3; ++k) {
          for (const EdgeUse& use : m_edges.uses(m_edge_of_side[3 * second + k])) {
            const int other = use.corner / 3;
            if (m_partner[other] >= 0) {
              waiting.push_back(std::min(other, m_partner[other]));
            }
          }
        }
      }
    }
    return drop_marked_triangles(m_mesh, m_is_dropped);
  }

 private:
  void mark(int triangle) {
    m_is_dropped[triangle] = 1;
    for (int k = 0; k < 3; ++k) {
      --m_uses[m_edge_of_side[3 * triangle + k]];
    }
  }

  /// Two at a time, which leaves odd and even as they are.
  void reduce_to_one_or_two(std::vector<int>& group) {
    if (group.size() > 2 && group.size() % 2 == 0) {
      const auto opposite = std::find_if(group.begin() + 1, group.end(), [&](int triangle) {
        return !is_same_winding(m_mesh.triangles[group[0]], m_mesh.triangles[triangle]);
      });
      if (opposite != group.end()) {
        std::iter_swap(group.begin() + 1, opposite);
      }
    }
    const std::size_t kept = group.size() % 2 == 0 ? 2 : 1;
    std::for_each(group.begin() + static_cast<long>(kept), group.end(), [&](int triangle) { mark(triangle); });
    group.resize(kept);
  }

  [[nodiscard]] bool is_one_too_many(int first) const {
    bool any_odd = false;
    for (int k = 0; k < 3; ++k) {
      const int uses = m_uses[m_edge_of_side[3 * first + k]];
      if (uses <= 2) {
        return false;
      }
      any_odd = any_odd || uses % 2 == 1;
    }
    return any_odd || is_same_winding(m_mesh.triangles[first], m_mesh.triangles[m_partner[first]]);
  }

  TriangleMesh& m_mesh;
  const MeshEdges& m_edges;
  std::vector<int> m_edge_of_side;
  std::vector<int> m_uses;  ///< of each edge, the triangles that are left at it
  std::vector<char> m_is_dropped;
  std::vector<int> m_partner;  ///< the triangle that coincides with this one, -1 for none
};

}  // namespace

int drop_doubled_triangles(TriangleMesh& mesh, const MeshEdges& edges) {
  const std::vector<std::vector<int>> groups = coincident_triangles(mesh, edges);
  return groups.empty() ? 0 : DoubledTriangles(mesh, edges).drop(groups);
}

}  // namespace musclebench
