#pragma once

#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A surface that is ready for signed distance queries. Positions are in metres.
struct RepairedMesh {
  TriangleMesh mesh;
  /// Whether the mesh is closed, edge- and vertex-manifold, one component, and wound outwards. Then the angle-weighted
  /// pseudo-normal of the closest feature gives the sign (Baerentzen and Aanaes 2005). Otherwise only the winding
  /// number does.
  bool clean = false;
  /// Lines for a report. First what was changed ("dropped 10 zero-area triangles"), then why the mesh is not clean
  /// ("left 3 non-manifold edges"). Empty for a clean mesh that needed no repair.
  std::vector<std::string> changes;
  /// True: every edge is used equally often in both directions, so `is_closed` can skip its test. False: unknown.
  bool known_closed = false;
};

/// Repairs a surface so that points have a well-defined side.
///
/// It merges vertices at equal positions. It drops unused vertices, triangles without area and duplicate triangles. It
/// winds each connected surface consistently, by the majority of its triangles, and then outwards (positive volume). It
/// closes small holes. Otherwise the surface as a set of points does not change. Vertices and triangles keep their
/// order, but numbers close up.
///
/// - A flat triangle with three different corners is merged into the triangle across its long side. That side is split,
///   so no gap opens.
/// - Two coincident triangles that close the surface (a fin without thickness) stay. A surplus one is dropped.
/// - A surface inside another one that is wound the other way is a cavity and stays so.
/// - A slightly open surface is accepted: fewer than 1 % of its edges are boundary edges, and its holes cover less than
///   1 % of its area. Each hole is closed by a fan of triangles. A hole whose rim is no closed loop stays open. The
///   winding number then gives the right side except next to the hole, and queries take far longer.
///
/// Self-intersections are not detected. Indices must be in range and vertices finite, as `read_mesh` guarantees. Throws
/// InputError that names `name` if no triangle has an area, or if the surface is too open. Safe from several threads.
RepairedMesh repair_mesh(const TriangleMesh& mesh, const std::string& name);

/// Whether a mesh is clean (RepairedMesh::clean) as it is, without repair. Takes as long as a repair.
bool is_clean(const TriangleMesh& mesh);

}  // namespace musclebench
