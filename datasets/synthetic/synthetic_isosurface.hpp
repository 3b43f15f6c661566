#pragma once

#include "core/mesh/triangle_mesh.hpp"
#include "datasets/synthetic/synthetic_field.hpp"

namespace musclebench {

/// The surface field = 0 within the box, by marching tetrahedra (six around each cube's diagonal) on cubes of
/// `cell_m`: closed, manifold and outward, provided that the solid does not reach the border of the box. Several
/// surfaces come out when the solid has several parts. Triangles are badly shaped; see remesh_isotropic.
TriangleMesh extract_isosurface(const Field& field, const Vec3& lower_m, const Vec3& upper_m, double cell_m);

/// The connected surface with the most triangles; the others are dropped, and so are unused vertices.
TriangleMesh largest_surface(const TriangleMesh& mesh);

}  // namespace musclebench
