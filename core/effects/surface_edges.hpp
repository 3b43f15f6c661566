#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// An edge of a surface with the corners opposite to it; -1 where there is no triangle on that side.
struct SurfaceEdge {
  int start = 0;
  int end = 0;
  int left = -1;   ///< opposite corner of the triangle that runs start -> end
  int right = -1;  ///< opposite corner of the triangle that runs end -> start
};

/// Every edge of the mesh once, ordered by graph colour and within a colour in mesh order. No two edges of a colour
/// share a vertex (of start, end, left, right), so that successive Gauss-Seidel steps do not depend on each other's
/// result. Of a non-manifold edge the last triangle on each side counts.
std::vector<SurfaceEdge> surface_edges(const TriangleMesh& mesh);

}  // namespace musclebench
