#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Closed shapes with an analytic signed distance, centred on the origin, edge- and vertex-manifold, wound outwards, in
/// metres. All vertices lie on the analytic shape, so that the mesh of a curved one is slightly smaller. They throw
/// std::invalid_argument for a size that is not positive and finite and for a count below its minimum.

/// Icosahedron whose triangles are split in four `subdivisions` (>= 0) times: 20 * 4^subdivisions triangles.
TriangleMesh make_sphere(double radius_m, int subdivisions);

/// Axis-aligned box; each face is a grid of cells_per_edge x cells_per_edge (>= 1) cells: 12 * cells_per_edge^2
/// triangles.
TriangleMesh make_box(const Vec3& half_extents_m, int cells_per_edge);

/// Cylinder along z from -half_length_m to half_length_m (>= 0) with half spheres at both ends; `segments` (>= 3)
/// around z, and about as many to the full circle in every other direction.
TriangleMesh make_capsule(double radius_m, double half_length_m, int segments);

}  // namespace musclebench
