#pragma once

#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What `musclebench check` reports of a mesh as shipped. Counts are zero for a healthy closed surface, but for
/// `duplicate_vertices`. Edges, vertices of triangles and components are those of the surface whose vertices at one
/// position are joined, as welding does: an STL file is no more open than the same surface as PLY.
struct MeshReport {
  int vertices = 0;
  int triangles = 0;
  int boundary_edges = 0;         ///< edges of one triangle
  int non_manifold_edges = 0;     ///< edges of more than two triangles
  int non_manifold_vertices = 0;  ///< vertices whose triangles form more than one fan
  int inconsistent_edges =
      0;                      ///< edges that several triangles run through in the same direction, a direction at a time
  int flipped_triangles = 0;  ///< triangles wound against the majority of their connected surface
  int zero_area_triangles = 0;  ///< smallest height below 1e-13 of the longest edge
  int duplicate_triangles = 0;  ///< triangles with the same three vertices as an earlier one
  int duplicate_vertices = 0;   ///< vertices at the position of an earlier one, which welding joins
  int unreferenced_vertices = 0;
  int components = 0;    ///< connected by shared vertices
  double volume_m3 = 0;  ///< signed, by the divergence theorem about the box's centre; negative when wound
                         ///< inwards; of an open surface no more than a hint
  double area_m2 = 0;
  double mean_edge_m = 0;
  double max_edge_m = 0;
  double worst_aspect = 0;    ///< longest edge over smallest height, of non-degenerate triangles
  Vec3 lower = Vec3::Zero();  ///< bounding box
  Vec3 upper = Vec3::Zero();
};

/// Examines the mesh as it is. Linear in its size. The triangles' indices must be in range and the vertices finite, as
/// `read_mesh` promises.
MeshReport check_mesh(const TriangleMesh& mesh);

/// The report as lines for a person: one line a defect ("defect: 4 triangles wound against the majority") or "no
/// defects" first, then counts and sizes. Neither several components nor duplicate vertices are a defect.
std::vector<std::string> describe(const MeshReport& report);

}  // namespace musclebench
