#include "core/mesh/mesh_edges.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <span>

#include <Eigen/Geometry>

namespace musclebench {

namespace {

/// By the larger vertex; equal ones stay in order.
void sort_stably_by_high(std::span<EdgeUse> uses) {
  constexpr std::size_t few = 32;  // a vertex of a surface has about six
  if (uses.size() > few) {
    std::stable_sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) { return a.high < b.high; });
    return;
  }
  for (std::size_t i = 1; i < uses.size(); ++i) {
    const EdgeUse use = uses[i];
    std::size_t to = i;
    for (; to > 0 && uses[to - 1].high > use.high; --to) uses[to] = uses[to - 1];
    uses[to] = use;
  }
}

}  // namespace

MeshEdges::MeshEdges(const TriangleMesh& mesh) {
  const auto for_each_side = [&](const auto& visit) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const int from = mesh.triangles[t][k];
        const int to = mesh.triangles[t][(k + 1) % 3];
        if (from != to) visit(EdgeUse{std::min(from, to), std::max(from, to), static_cast<int>(3 * t) + k, from < to});
      }
    }
  };
  // Counting sort by the smaller vertex; `end` moves from the first of its uses to one past the last.
  std::vector<int> end(mesh.vertices.size() + 1, 0);
  for_each_side([&](const EdgeUse& use) { ++end[use.low + 1]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  m_uses.resize(end.back());
  for_each_side([&](const EdgeUse& use) { m_uses[end[use.low]++] = use; });
  m_first.reserve(m_uses.size() / 2 + 1);
  int first = 0;
  for (std::size_t vertex = 0; vertex < mesh.vertices.size(); ++vertex) {
    sort_stably_by_high(std::span(m_uses).subspan(first, end[vertex] - first));
    for (int use = first; use < end[vertex]; ++use) {
      if (use == first || m_uses[use].high != m_uses[use - 1].high) m_first.push_back(use);
    }
    first = end[vertex];
  }
  m_first.push_back(first);
}

std::vector<int> edge_of_sides(const TriangleMesh& mesh, const MeshEdges& edges) {
  std::vector<int> edge_of_side(3 * mesh.triangles.size(), -1);
  for (int edge = 0; edge < edges.count(); ++edge) {
    for (const EdgeUse& use : edges.uses(edge)) {
      edge_of_side[use.corner] = edge;
    }
  }
  return edge_of_side;
}

DisjointSets::DisjointSets(int count) : m_parent(count) { std::iota(m_parent.begin(), m_parent.end(), 0); }

int DisjointSets::find(int element) {
  while (m_parent[element] != element) {
    m_parent[element] = m_parent[m_parent[element]];
    element = m_parent[element];
  }
  return element;
}

bool DisjointSets::unite(int a, int b) {
  const int root_a = find(a);
  const int root_b = find(b);
  m_parent[std::max(root_a, root_b)] = std::min(root_a, root_b);
  return root_a != root_b;
}

std::vector<int> first_of_component(const TriangleMesh& mesh) {
  DisjointSets joined(static_cast<int>(mesh.vertices.size()));
  for (const Triangle& triangle : mesh.triangles) {
    joined.unite(triangle[0], triangle[1]);
    joined.unite(triangle[0], triangle[2]);
  }
  std::vector<int> first(mesh.vertices.size());
  for (std::size_t vertex = 0; vertex < first.size(); ++vertex) {
    first[vertex] = joined.find(static_cast<int>(vertex));
  }
  return first;
}

namespace {

std::size_t hash_of(const Vec3& position) {
  std::uint64_t hash = 0x9e3779b97f4a7c15ULL;
  for (const double coordinate : position) {
    // Adding zero turns -0 into 0: equal positions must have equal bits.
    hash = (hash ^ std::bit_cast<std::uint64_t>(coordinate + 0.0)) * 0xff51afd7ed558ccdULL;
    hash ^= hash >> 32;
  }
  return hash;
}

}  // namespace

std::vector<int> first_at_position(const std::vector<Vec3>& vertices) {
  // Open addressing: a table twice as large as what it holds, which is indices only.
  std::vector<int> table(std::bit_ceil(2 * vertices.size() + 1), -1);
  const std::size_t mask = table.size() - 1;
  std::vector<int> first(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    std::size_t slot = hash_of(vertices[i]) & mask;
    while (table[slot] >= 0 && vertices[static_cast<std::size_t>(table[slot])] != vertices[i]) {
      slot = (slot + 1) & mask;
    }
    if (table[slot] < 0) {
      table[slot] = static_cast<int>(i);
    }
    first[i] = table[slot];
  }
  return first;
}

int count_non_manifold_vertices(const TriangleMesh& mesh, const MeshEdges& edges) {
  // Each corner is a fan of its own until it is joined to others across the edges of its vertex.
  std::vector<int> fans_of_vertex(mesh.vertices.size(), 0);
  for (const Triangle& triangle : mesh.triangles) {
    for (const int vertex : triangle) ++fans_of_vertex[vertex];
  }
  DisjointSets fans(static_cast<int>(3 * mesh.triangles.size()));
  const auto corners_of = [](const EdgeUse& use) {
    const int from = use.corner;
    const int to = from % 3 == 2 ? from - 2 : from + 1;
    return use.forward ? std::array{from, to} : std::array{to, from};
  };
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    const auto [low, high] = corners_of(uses[0]);
    for (const EdgeUse& use : uses.subspan(1)) {
      const auto [other_low, other_high] = corners_of(use);
      fans_of_vertex[use.low] -= fans.unite(low, other_low) ? 1 : 0;
      fans_of_vertex[use.high] -= fans.unite(high, other_high) ? 1 : 0;
    }
  }
  return static_cast<int>(std::count_if(fans_of_vertex.begin(), fans_of_vertex.end(), [](int n) { return n > 1; }));
}

Winding find_winding(const TriangleMesh& mesh, const MeshEdges& edges) {
  // Across each side of a triangle: 2 * neighbour + (1 where it is wound the other way), -1 for none.
  std::vector<std::array<int, 3>> across(mesh.triangles.size(), {-1, -1, -1});
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    if (uses.size() == 2) {
      const int opposed = uses[0].forward == uses[1].forward ? 1 : 0;
      across[uses[0].corner / 3][uses[0].corner % 3] = 2 * (uses[1].corner / 3) + opposed;
      across[uses[1].corner / 3][uses[1].corner % 3] = 2 * (uses[0].corner / 3) + opposed;
    }
  }
  Winding winding;
  winding.surface.assign(mesh.triangles.size(), -1);
  winding.flipped.assign(mesh.triangles.size(), 0);
  std::vector<int> members;
  for (std::size_t seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (winding.surface[seed] >= 0) {
      continue;
    }
    members.assign(1, static_cast<int>(seed));
    winding.surface[seed] = winding.surfaces;
    std::size_t opposed_count = 0;
    for (std::size_t next = 0; next < members.size(); ++next) {
      const int triangle = members[next];
      opposed_count += winding.flipped[triangle];
      for (const int side : across[triangle]) {
        if (side >= 0 && winding.surface[side / 2] < 0) {
          winding.surface[side / 2] = winding.surfaces;
          winding.flipped[side / 2] = static_cast<char>(winding.flipped[triangle] != side % 2);
          members.push_back(side / 2);
        }
      }
    }
    if (2 * opposed_count > members.size()) {
      for (const int triangle : members) {
        winding.flipped[triangle] = static_cast<char>(1 - winding.flipped[triangle]);
      }
    }
    ++winding.surfaces;
  }
  return winding;
}

bool is_flat(const TriangleMesh& mesh, const Triangle& triangle) {
  // Height over the longest side, relative to that side; slivers of real meshes are many decades above.
  constexpr double flat_height = 1e-13;
  const Vec3& a = mesh.vertices[triangle[0]];
  const Vec3& b = mesh.vertices[triangle[1]];
  const Vec3& c = mesh.vertices[triangle[2]];
  const double longest_squared = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return (b - a).cross(c - a).norm() <= flat_height * longest_squared;
}

}  // namespace musclebench
