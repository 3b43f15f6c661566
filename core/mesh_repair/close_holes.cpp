#include "core/mesh_repair/close_holes.hpp"

#include <cstddef>
#include <map>
#include <vector>

namespace musclebench {

namespace {

/// Against the direction in which the triangle beside it runs along it.
struct RimEdge {
  int from;
  int to;
};

/// By hole, in the order of the first edge of each.
std::vector<std::vector<RimEdge>> find_rims(const TriangleMesh& mesh, const MeshEdges& edges) {
  DisjointSets joined(static_cast<int>(mesh.vertices.size()));
  std::vector<RimEdge> all;
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    if (uses.size() != 1) continue;
    all.push_back(uses[0].forward ? RimEdge{uses[0].high, uses[0].low} : RimEdge{uses[0].low, uses[0].high});
    joined.unite(uses[0].low, uses[0].high);
  }
  std::vector<std::vector<RimEdge>> rims;
  std::map<int, std::size_t> rim_of;
  for (const RimEdge& edge : all) {
    const auto [found, is_new] = rim_of.try_emplace(joined.find(edge.from), rims.size());
    if (is_new) rims.emplace_back();
    rims[found->second].push_back(edge);
  }
  return rims;
}

/// Whether as many edges lead to each vertex as leave it.
bool is_made_of_loops(const std::vector<RimEdge>& rim) {
  std::map<int, int> balance;
  for (const RimEdge& edge : rim) {
    ++balance[edge.from];
    --balance[edge.to];
  }
  for (const auto& [vertex, excess] : balance) {
    if (excess != 0) return false;
  }
  return true;
}

int third_corner(const std::vector<RimEdge>& triangle) {
  for (const RimEdge& edge : triangle) {
    if (edge.from != triangle.front().from && edge.from != triangle.front().to) return edge.from;
  }
  return -1;
}

void add_fan(TriangleMesh& mesh, const std::vector<RimEdge>& rim) {
  Vec3 middle = Vec3::Zero();
  for (const RimEdge& edge : rim) middle += mesh.vertices[static_cast<std::size_t>(edge.from)];
  const auto centre = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(middle / static_cast<double>(rim.size()));
  for (const RimEdge& edge : rim) mesh.triangles.push_back({edge.from, edge.to, centre});
}

}  // namespace

ClosedHoles close_holes(TriangleMesh& mesh, const MeshEdges& edges) {
  ClosedHoles closed;
  for (const std::vector<RimEdge>& rim : find_rims(mesh, edges)) {
    if (!is_made_of_loops(rim)) continue;
    const int third = rim.size() == 3 ? third_corner(rim) : -1;
    if (third >= 0) {
      mesh.triangles.push_back({rim.front().from, rim.front().to, third});
    } else {
      add_fan(mesh, rim);
    }
    ++closed.holes;
    closed.boundary_edges += static_cast<int>(rim.size());
  }
  return closed;
}

}  // namespace musclebench
