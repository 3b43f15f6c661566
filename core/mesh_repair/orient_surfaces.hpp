#pragma once

#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What `orient_surfaces` did.
struct OrientationChange {
  int triangles_turned = 0;  ///< against the majority of their connected surface
  int surfaces_turned = 0;   ///< as a whole, because they were wound inwards
  int surfaces = 0;          ///< connected across manifold edges
};

/// Winds each surface that is connected across manifold edges like the majority of its triangles, then outwards:
/// positive volume. Surfaces that only meet in non-manifold edges are judged one by one where each is closed by itself,
/// else together. A surface that lies inside another one keeps its sense relative to it: wound inwards it is a cavity,
/// which is legitimate, and nothing tells it from a mistake. `edges` are those of `mesh`.
OrientationChange orient_surfaces(TriangleMesh& mesh, const MeshEdges& edges);

}  // namespace musclebench
