#include "core/mesh_repair/sharp_features.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

constexpr double largest_radius_share = 0.01;

/// Unit; zero for a triangle without area, whose edges are never sharp.
std::vector<Vec3> face_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals;
  normals.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    const auto& [a, b, c] = triangle;
    const Vec3 normal = (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    normals.push_back(is_flat(mesh, triangle) ? Vec3(Vec3::Zero()) : Vec3(normal.stableNormalized()));
  }
  return normals;
}

bool turns(const Vec3& one, const Vec3& other, double cosine) {
  return !one.isZero(0) && !other.isZero(0) && one.dot(other) < cosine;
}

std::vector<Triangle> sharp_edges(const MeshEdges& edges, const std::vector<Vec3>& normals, double cosine) {
  std::vector<Triangle> sharp;
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    const auto normal_of = [&](std::size_t use) { return normals[uses[use].corner / 3]; };
    if (uses.size() != 2 || turns(normal_of(0), normal_of(1), cosine)) {
      sharp.push_back({uses[0].low, uses[0].high, uses[0].high});
    }
  }
  return sharp;
}

std::vector<Triangle> sharp_vertices(const TriangleMesh& mesh, const std::vector<Vec3>& normals, double cosine) {
  std::vector<std::vector<int>> around(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const int vertex : mesh.triangles[t]) {
      around[vertex].push_back(static_cast<int>(t));
    }
  }
  std::vector<Triangle> sharp;
  for (std::size_t vertex = 0; vertex < around.size(); ++vertex) {
    const std::vector<int>& fan = around[vertex];
    const bool any = std::any_of(fan.begin(), fan.end(), [&](int one) {
      return std::any_of(fan.begin(), fan.end(),
                         [&](int other) { return turns(normals[one], normals[other], cosine); });
    });
    if (any) {
      const int v = static_cast<int>(vertex);
      sharp.push_back({v, v, v});
    }
  }
  return sharp;
}

double mean_edge_m(const TriangleMesh& mesh, const MeshEdges& edges) {
  double sum = 0;
  for (int edge = 0; edge < edges.count(); ++edge) {
    const EdgeUse& use = edges.uses(edge).front();
    sum += (mesh.vertices[use.high] - mesh.vertices[use.low]).norm();
  }
  return edges.count() > 0 ? sum / edges.count() : 0;
}

}  // namespace

SharpFeatures::SharpFeatures(const TriangleMesh& mesh, double turn_rad) {
  const MeshEdges edges(mesh);
  const std::vector<Vec3> normals = face_normals(mesh);
  const double cosine = std::cos(turn_rad);
  TriangleMesh features{mesh.vertices, sharp_edges(edges, normals, cosine)};
  const std::vector<Triangle> vertices = sharp_vertices(mesh, normals, cosine);
  m_edges = static_cast<int>(features.triangles.size());
  m_vertices = static_cast<int>(vertices.size());
  features.triangles.insert(features.triangles.end(), vertices.begin(), vertices.end());
  m_radius_m = std::min(mean_edge_m(mesh, edges), largest_radius_share * bounding_box(mesh.vertices).diagonal().norm());
  if (!features.triangles.empty()) {
    m_features.emplace(features);
  }
}

}  // namespace musclebench
