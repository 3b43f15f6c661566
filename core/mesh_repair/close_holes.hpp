#pragma once

#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What `close_holes` did.
struct ClosedHoles {
  int holes = 0;           ///< that were closed
  int boundary_edges = 0;  ///< of these
};

/// Closes each hole by a fan of triangles about the middle of its rim, or by one triangle where the rim has three
/// edges; wound as the triangles around it. Holes that touch at a vertex are closed one by one. What is left of a rim
/// that is no closed loop stays open, and so does a loose triangle. `edges` are those of the mesh, which is wound
/// consistently; new triangles and vertices come last.
ClosedHoles close_holes(TriangleMesh& mesh, const MeshEdges& edges);

}  // namespace musclebench
