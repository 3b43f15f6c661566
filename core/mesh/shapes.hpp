#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

// Closed test shapes with a known signed distance, centred on the origin, in metres. They are manifold and wound
// outwards. All vertices lie on the exact shape, so the mesh of a curved shape is slightly smaller than the shape. All
// functions throw std::invalid_argument for a size that is not positive and finite, and for a count below its minimum.

/// An icosahedron whose triangles are split in four `subdivisions` (>= 0) times. It has 20 * 4^subdivisions triangles.
TriangleMesh make_sphere(double radius_m, int subdivisions);

/// An axis-aligned box. Each face is a grid of `cells_per_edge` (>= 1) squared cells. It has 12 * cells_per_edge^2
/// triangles.
TriangleMesh make_box(const Vec3& half_extents_m, int cells_per_edge);

/// A cylinder along z from -half_length_m to half_length_m (>= 0), closed by half spheres. It has `segments` (>= 3)
/// around z, and about as many on a full circle in any other plane.
TriangleMesh make_capsule(double radius_m, double half_length_m, int segments);

}  // namespace musclebench
