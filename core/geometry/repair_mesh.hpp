#pragma once

#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.hpp"

namespace musclebench {

/// A surface made ready for signed distance.
struct RepairedMesh {
  TriangleMesh mesh;
  /// Closed, edge- and vertex-manifold, consistently wound outwards, one component: the angle-weighted pseudo-normal of
  /// the closest feature gives the sign (Baerentzen and Aanaes 2005). Otherwise only the winding number does.
  bool clean = false;
  /// What was changed, one line each ("dropped 10 zero-area triangles"), for the report.
  std::vector<std::string> changes;
};

/// Merges vertices at equal positions, drops unreferenced vertices, zero-area and doubled triangles, winds each connected
/// surface consistently (across manifold edges, by majority) and outwards (positive volume). The surface as a set of points
/// is unchanged. Throws InputError (place: `name`) where no surface is left or the surface has boundary edges.
RepairedMesh repair_mesh(const TriangleMesh& mesh, const std::string& name);

}  // namespace musclebench
