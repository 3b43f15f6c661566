#include "backends/cgal/cgal_mesh.hpp"

#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <algorithm>
#include <array>
#include <cstddef>

namespace musclebench {

CgalSurface to_cgal(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  std::vector<int> vertex_of;
  for (const Triangle& triangle : triangles) vertex_of.insert(vertex_of.end(), triangle.begin(), triangle.end());
  std::sort(vertex_of.begin(), vertex_of.end());
  vertex_of.erase(std::unique(vertex_of.begin(), vertex_of.end()), vertex_of.end());
  std::vector<CgalPoint> points;
  for (const int vertex : vertex_of) points.push_back(to_cgal(positions[static_cast<std::size_t>(vertex)]));
  std::vector<std::array<std::size_t, 3>> faces;
  for (const Triangle& triangle : triangles) {
    std::array<std::size_t, 3> face;
    std::transform(triangle.begin(), triangle.end(), face.begin(), [&](int vertex) {
      return static_cast<std::size_t>(std::lower_bound(vertex_of.begin(), vertex_of.end(), vertex) - vertex_of.begin());
    });
    faces.push_back(face);
  }
  const std::vector<std::array<std::size_t, 3>> before = faces;
  CgalSurface surface;
  CGAL::Polygon_mesh_processing::orient_polygon_soup(points, faces);
  // A vertex that was doubled is at the same place as one of the corners that its face had.
  vertex_of.resize(points.size(), -1);
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (const std::size_t vertex : faces[face]) {
      for (const std::size_t corner : before[face]) {
        if (vertex_of[vertex] < 0 && points[vertex] == points[corner]) vertex_of[vertex] = vertex_of[corner];
      }
    }
  }
  CGAL::Polygon_mesh_processing::polygon_soup_to_polygon_mesh(points, faces, surface.mesh);
  surface.vertex_of = std::move(vertex_of);
  return surface;
}

std::size_t cgal_bytes(const CgalMesh& mesh, bool accelerates) {
  const std::size_t of_mesh =
      mesh.number_of_vertices() * sizeof(CgalPoint) + mesh.number_of_halfedges() * 4 * sizeof(CgalMesh::size_type);
  const std::size_t node = sizeof(CGAL::Bbox_3) + 2 * sizeof(void*);
  const std::size_t search = accelerates ? sizeof(CgalPoint) + 2 * sizeof(void*) : 0;
  return of_mesh + mesh.number_of_faces() * (sizeof(CgalPrimitive) + node + search);
}

}  // namespace musclebench
