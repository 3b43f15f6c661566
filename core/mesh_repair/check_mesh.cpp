#include "core/mesh_repair/check_mesh.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "core/mesh/mesh_edges.hpp"
#include "core/mesh_repair/merge_vertices.hpp"

namespace musclebench {

namespace {

void measure_edges(const TriangleMesh& mesh, const MeshEdges& edges, MeshReport& report) {
  double sum_m = 0;
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    const auto forward = std::count_if(uses.begin(), uses.end(), [](const EdgeUse& use) { return use.forward; });
    report.boundary_edges += uses.size() == 1 ? 1 : 0;
    report.non_manifold_edges += uses.size() > 2 ? 1 : 0;
    // A direction that two triangles run through is wrong for at least one of them.
    report.inconsistent_edges += (forward > 1 ? 1 : 0) + (static_cast<long>(uses.size()) - forward > 1 ? 1 : 0);
    const double length_m = (mesh.vertices[uses[0].low] - mesh.vertices[uses[0].high]).norm();
    sum_m += length_m;
    report.max_edge_m = std::max(report.max_edge_m, length_m);
  }
  report.mean_edge_m = edges.count() > 0 ? sum_m / edges.count() : 0;
}

void measure_triangles(const TriangleMesh& mesh, MeshReport& report) {
  const Vec3 origin = (report.lower + report.upper) / 2;  // keeps the digits of the volume far from the origin
  double six_volumes = 0;
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3 a = mesh.vertices[triangle[0]] - origin;
    const Vec3 b = mesh.vertices[triangle[1]] - origin;
    const Vec3 c = mesh.vertices[triangle[2]] - origin;
    const double twice_area = (b - a).cross(c - a).norm();
    six_volumes += a.dot(b.cross(c));
    report.area_m2 += twice_area / 2;
    if (is_flat(mesh, triangle)) {
      ++report.zero_area_triangles;
      continue;
    }
    const double longest_squared = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    report.worst_aspect = std::max(report.worst_aspect, longest_squared / twice_area);
  }
  report.volume_m3 = six_volumes / 6;
}

int count_duplicate_triangles(const TriangleMesh& mesh) {
  std::vector<Triangle> sorted = mesh.triangles;
  for (Triangle& triangle : sorted) {
    std::sort(triangle.begin(), triangle.end());
  }
  std::sort(sorted.begin(), sorted.end());
  return static_cast<int>(sorted.end() - std::unique(sorted.begin(), sorted.end()));
}

/// `joined`: the mesh with its triangles at the first of all vertices at one position.
void count_vertices(const TriangleMesh& mesh, const TriangleMesh& joined, MeshReport& report) {
  std::vector<char> is_used(mesh.vertices.size(), 0);
  for (const Triangle& triangle : mesh.triangles) {
    for (const int vertex : triangle) {
      is_used[vertex] = 1;
    }
  }
  report.unreferenced_vertices = static_cast<int>(std::count(is_used.begin(), is_used.end(), 0));
  std::fill(is_used.begin(), is_used.end(), 0);
  for (const Triangle& triangle : joined.triangles) {
    for (const int vertex : triangle) {
      is_used[vertex] = 1;
    }
  }
  const std::vector<int> first = first_of_component(joined);
  for (int vertex = 0; vertex < report.vertices; ++vertex) {
    report.components += is_used[vertex] != 0 && first[vertex] == vertex ? 1 : 0;
  }
}

}  // namespace

MeshReport check_mesh(const TriangleMesh& mesh) {
  MeshReport report;
  report.vertices = static_cast<int>(mesh.vertices.size());
  report.triangles = static_cast<int>(mesh.triangles.size());
  if (!mesh.vertices.empty()) {
    report.lower = report.upper = mesh.vertices.front();
  }
  for (const Vec3& vertex : mesh.vertices) {
    report.lower = report.lower.cwiseMin(vertex);
    report.upper = report.upper.cwiseMax(vertex);
  }
  // Formats without indices, such as STL, give every triangle vertices of its own: the surface is what is left once
  // those at one position are joined, as scenes do.
  TriangleMesh joined = mesh;
  const std::vector<int> first = first_at_position(mesh.vertices);
  merge_vertices(joined, first);
  for (int vertex = 0; vertex < report.vertices; ++vertex) {
    report.duplicate_vertices += first[vertex] != vertex ? 1 : 0;
  }
  const MeshEdges edges(joined);
  measure_edges(joined, edges, report);
  measure_triangles(joined, report);
  count_vertices(mesh, joined, report);
  report.duplicate_triangles = count_duplicate_triangles(joined);
  report.non_manifold_vertices = count_non_manifold_vertices(joined, edges);
  const Winding winding = find_winding(joined, edges);
  report.flipped_triangles = static_cast<int>(std::count(winding.flipped.begin(), winding.flipped.end(), 1));
  return report;
}

std::vector<std::string> describe(const MeshReport& report) {
  std::vector<std::string> lines;
  const auto defect = [&](int count, const char* what) {
    if (count > 0) {
      lines.push_back(fmt::format("defect: {} {}", count, what));
    }
  };
  defect(report.triangles == 0 ? 1 : 0, "surface without triangles");
  defect(report.boundary_edges, "boundary edges (the surface is open)");
  defect(report.non_manifold_edges, "non-manifold edges (of more than two triangles)");
  defect(report.non_manifold_vertices, "non-manifold vertices (surfaces that touch in a point)");
  defect(report.inconsistent_edges, "inconsistently wound edges");
  defect(report.flipped_triangles, "triangles wound against the majority");
  defect(report.zero_area_triangles, "zero-area triangles");
  defect(report.duplicate_triangles, "duplicate triangles");
  defect(report.unreferenced_vertices, "unreferenced vertices");
  if (report.volume_m3 < 0) {
    lines.emplace_back("defect: wound inwards (the volume is negative)");
  }
  if (lines.empty()) {
    lines.emplace_back("no defects");
  }
  if (report.duplicate_vertices > 0) {
    lines.push_back(fmt::format("{} duplicate vertices (at the position of an earlier one): welding joins them",
                                report.duplicate_vertices));
  }
  const Vec3 size_mm = 1e3 * (report.upper - report.lower);
  lines.push_back(fmt::format("{} vertices, {} triangles, {} component{}", report.vertices, report.triangles,
                              report.components, report.components == 1 ? "" : "s"));
  lines.push_back(fmt::format("volume {:.3f} ml, area {:.2f} cm2, box {:.2f} x {:.2f} x {:.2f} mm",
                              1e6 * report.volume_m3, 1e4 * report.area_m2, size_mm.x(), size_mm.y(), size_mm.z()));
  lines.push_back(fmt::format("edges {:.3f} mm in the mean, {:.3f} mm at most, worst aspect {:.4g}",
                              1e3 * report.mean_edge_m, 1e3 * report.max_edge_m, report.worst_aspect));
  return lines;
}

}  // namespace musclebench
