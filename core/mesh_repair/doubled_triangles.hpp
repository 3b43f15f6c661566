#pragma once

#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Drops triangles that are there twice. Two coincident triangles may also be a fin, a fold of the surface without
/// thickness, which closes the surface and must stay. What tells them apart is the number of triangles at their edges:
/// in a fin it is even and 2 at its rim, a triangle too many makes it odd. `edges` are those of the mesh.
/// Returns how many were dropped.
int drop_doubled_triangles(TriangleMesh& mesh, const MeshEdges& edges);

}  // namespace musclebench
