#pragma once

#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A surface whose vertices can be simulated as nodes.
struct WeldedMesh {
  TriangleMesh mesh;
  /// Of each vertex of the original the vertex of `mesh` at its position; -1 where no triangle uses it.
  std::vector<int> welded_vertex;
  /// What was changed, one line each, for the report. Empty for a mesh that needed nothing.
  std::vector<std::string> changes;
};

/// Joins vertices at equal positions, drops triangles that this leaves with fewer than three corners, doubled triangles
/// and vertices that no triangle uses, and winds surfaces as `repair_mesh` does. What stays keeps its order, and flat
/// triangles stay: unlike a bone, a muscle needs its edges. Openness is accepted. The triangles' indices must be in
/// range and the vertices finite, as `read_mesh` promises. Throws InputError (location: `name`) where no triangle is
/// left.
WeldedMesh weld_mesh(const TriangleMesh& mesh, const std::string& name);

}  // namespace musclebench
