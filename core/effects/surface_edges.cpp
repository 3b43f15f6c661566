#include "core/effects/surface_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/constraints/graph_colours.hpp"

namespace musclebench {

namespace {

struct HalfEdge {
  int low;
  int high;
  int opposite;
  bool forward;  ///< runs low -> high
};

std::vector<SurfaceEdge> edges_in_mesh_order(const TriangleMesh& mesh) {
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      const int from = triangle[corner];
      const int to = triangle[(corner + 1) % 3];
      half_edges.push_back({std::min(from, to), std::max(from, to), triangle[(corner + 2) % 3], from < to});
    }
  }
  std::stable_sort(half_edges.begin(), half_edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return a.low != b.low ? a.low < b.low : a.high < b.high;
  });
  std::vector<SurfaceEdge> edges;
  for (const HalfEdge& half : half_edges) {
    if (edges.empty() || edges.back().start != half.low || edges.back().end != half.high) {
      edges.push_back({half.low, half.high, -1, -1});
    }
    (half.forward ? edges.back().left : edges.back().right) = half.opposite;
  }
  return edges;
}

}  // namespace

std::vector<SurfaceEdge> surface_edges(const TriangleMesh& mesh) {
  const std::vector<SurfaceEdge> edges = edges_in_mesh_order(mesh);
  std::vector<std::array<int, 4>> corners;
  corners.reserve(edges.size());
  for (const SurfaceEdge& edge : edges) corners.push_back({edge.start, edge.end, edge.left, edge.right});
  const std::vector<int> order = order_by_colour<4>(corners, mesh.vertices.size());
  std::vector<SurfaceEdge> coloured;
  coloured.reserve(edges.size());
  for (const int edge : order) {
    coloured.push_back(edges[edge]);
  }
  return coloured;
}

double relative_area(const TriangleMesh& mesh, const SurfaceEdge& edge) {
  constexpr double least = 1e-6;
  const double of_equilateral = std::sqrt(3.0) / 2;
  const Vec3 along = mesh.vertices[edge.end] - mesh.vertices[edge.start];
  double area_m2 = 0;
  for (const int corner : {edge.left, edge.right}) {
    if (corner >= 0) area_m2 += 0.5 * along.cross(mesh.vertices[corner] - mesh.vertices[edge.start]).norm();
  }
  const double length2_m2 = along.squaredNorm();
  return length2_m2 > 0 ? std::max(area_m2 / (of_equilateral * length2_m2), least) : least;
}

ParameterSpec per_area_flag(const std::string& constraint) {
  return parameter::flag({.name = "per_area",
                          .default_value = false,
                          .help = "the compliance is that of one " + constraint +
                                  " between equilateral triangles; others get theirs by area and length. Nothing "
                                  "without a compliance"});
}

}  // namespace musclebench
