#pragma once

#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A surface made ready for signed distance.
struct RepairedMesh {
  TriangleMesh mesh;
  /// Closed, edge- and vertex-manifold, consistently wound outwards, one component: the angle-weighted pseudo-normal of
  /// the closest feature gives the sign (Baerentzen and Aanaes 2005). Otherwise only the winding number does.
  bool clean = false;
  /// What was changed, one line each ("dropped 10 zero-area triangles"), then what is left that keeps the mesh from
  /// being clean ("left 3 non-manifold edges"), for the report. Empty for a clean mesh that needed nothing.
  std::vector<std::string> changes;
  /// Every edge is used as often in one direction as in the other, so that `is_closed` need not look; false: not known.
  bool known_closed = false;
};

/// Merges vertices at equal positions, drops unreferenced vertices, zero-area and doubled triangles, winds each
/// connected surface consistently (across manifold edges, by majority) and outwards (positive volume), and closes small
/// holes. But for these the surface as a set of points is unchanged; vertices and triangles are renumbered where
/// something was dropped, and keep their order.
/// - A flat triangle with three distinct corners is merged into the triangle across its long side, which is split
///   there, so that no gap opens.
/// - Two coincident triangles that close the surface (a fin without thickness) stay; one that is too many goes.
/// - A surface inside another one keeps its sense relative to it: one that is wound inwards there is taken for a
///   cavity.
/// - An open surface is accepted where fewer than 1 % of its edges are boundary edges and its holes are less than 1 %
/// of
///   its area. Each hole is closed by a fan of triangles (`close_holes`). One whose rim is no closed loop stays open;
///   the winding number then still tells in from out but next to it, and queries take far longer.
/// Self-intersections are not detected. The triangles' indices must be in range and the vertices finite, as
/// `read_mesh` promises. Throws InputError (location: `name`) where no triangle has an area or the surface is open
/// beyond that.
RepairedMesh repair_mesh(const TriangleMesh& mesh, const std::string& name);

}  // namespace musclebench
