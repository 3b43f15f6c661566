#pragma once

#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.hpp"

namespace musclebench {

/// What `musclebench check` reports of a mesh as shipped. Counts are zero for a healthy closed surface.
struct MeshReport {
  int vertices = 0;
  int triangles = 0;
  int boundary_edges = 0;               ///< edges of one triangle
  int non_manifold_edges = 0;           ///< edges of more than two triangles
  int inconsistent_edges = 0;           ///< edges that two triangles run through in the same direction
  int flipped_triangles = 0;            ///< triangles wound against the majority of their connected surface
  int zero_area_triangles = 0;
  int duplicate_triangles = 0;          ///< triangles with the same three vertices as an earlier one
  int duplicate_vertices = 0;           ///< vertices at the position of an earlier one
  int unreferenced_vertices = 0;
  int components = 0;                   ///< connected by shared vertices
  double volume_m3 = 0;                 ///< signed, by the divergence theorem; negative when wound inwards
  double area_m2 = 0;
  double mean_edge_m = 0;
  double max_edge_m = 0;
  double worst_aspect = 0;              ///< longest edge over smallest height, of non-degenerate triangles
  Vec3 lower = Vec3::Zero();            ///< bounding box
  Vec3 upper = Vec3::Zero();
};

MeshReport check_mesh(const TriangleMesh& mesh);

/// The report as lines for a person; defects first, "no defects" when there are none.
std::vector<std::string> describe(const MeshReport& report);

}  // namespace musclebench
