#include "core/mesh_repair/close_holes.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace musclebench {

namespace {

/// Against the direction in which the triangle beside it runs along it.
struct RimEdge {
  int from = 0;
  int to = 0;
  int triangle = 0;
};

using Loop = std::vector<RimEdge>;

/// By their first vertex, so that the order of the loops does not depend on that of the triangles.
std::vector<RimEdge> rim_edges(const MeshEdges& edges) {
  std::vector<RimEdge> rim;
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    if (uses.size() != 1) continue;
    const auto [low, high, corner, forward] = uses[0];
    rim.push_back(forward ? RimEdge{high, low, corner / 3} : RimEdge{low, high, corner / 3});
  }
  std::ranges::stable_sort(rim, {}, &RimEdge::from);
  return rim;
}

/// Follows the rims from each edge that is left. A path that comes back to a vertex has closed a loop there, which is
/// cut off, so that holes that touch each other at a vertex are closed one by one. A path that ends is no loop.
std::vector<Loop> find_loops(const MeshEdges& edges) {
  const std::vector<RimEdge> rim = rim_edges(edges);
  std::vector<char> is_used(rim.size(), 0);
  std::vector<Loop> loops;
  for (std::size_t first = 0; first < rim.size(); ++first) {
    if (is_used[first] != 0) continue;
    is_used[first] = 1;
    Loop path = {rim[first]};
    while (!path.empty()) {
      const int at = path.back().to;
      const auto closed = std::ranges::find(path, at, &RimEdge::from);
      if (closed != path.end()) {
        loops.emplace_back(closed, path.end());
        path.erase(closed, path.end());
        continue;
      }
      auto next = std::ranges::lower_bound(rim, at, {}, &RimEdge::from);
      while (next != rim.end() && next->from == at && is_used[static_cast<std::size_t>(next - rim.begin())] != 0)
        ++next;
      if (next == rim.end() || next->from != at) break;
      is_used[static_cast<std::size_t>(next - rim.begin())] = 1;
      path.push_back(*next);
    }
  }
  return loops;
}

/// A loose triangle, which has no surface around it.
bool is_one_triangle(const Loop& loop) {
  return std::ranges::all_of(loop, [&](const RimEdge& edge) { return edge.triangle == loop.front().triangle; });
}

void add_fan(TriangleMesh& mesh, const Loop& loop) {
  Vec3 middle = Vec3::Zero();
  for (const RimEdge& edge : loop) middle += mesh.vertices[static_cast<std::size_t>(edge.from)];
  const auto centre = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(middle / static_cast<double>(loop.size()));
  for (const RimEdge& edge : loop) mesh.triangles.push_back({edge.from, edge.to, centre});
}

}  // namespace

ClosedHoles close_holes(TriangleMesh& mesh, const MeshEdges& edges) {
  ClosedHoles closed;
  for (const Loop& loop : find_loops(edges)) {
    if (loop.size() < 3 || is_one_triangle(loop)) continue;
    if (loop.size() == 3) {
      mesh.triangles.push_back({loop[0].from, loop[1].from, loop[2].from});
    } else {
      add_fan(mesh, loop);
    }
    ++closed.holes;
    closed.boundary_edges += static_cast<int>(loop.size());
  }
  return closed;
}

}  // namespace musclebench
