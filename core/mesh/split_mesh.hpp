#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

// Finer meshes. Each triangle becomes four, joined at the middles of its sides, `times` (>= 0) times. Vertices keep
// their indices and positions; new ones follow. Triangles keep their winding. Two sides with the same ends get the same
// middle, to the last bit, also where they are sides of different vertices at one position.

/// New vertices lie on the triangles: the surface stays the same set of points.
TriangleMesh split_flat(TriangleMesh mesh, int times);

/// New vertices lie on a curved surface through the old ones, which a coarse mesh of a smooth body stands for: the
/// middle of the cubic side of a PN triangle (Vlachos and others 2001, "Curved PN triangles"), with vertex normals that
/// are exact for points of a sphere (Max 1999, "Weights for computing vertex normals from facet normals"). The error on
/// a sphere falls with the fourth power of the edges' length, that of flat triangles with the second.
///
/// Corners and creases stay sharp: a vertex of a border, or of an edge whose triangles meet at more than 60 degrees,
/// has no normal, and its sides leave it straight. Triangles have to be wound alike.
TriangleMesh split_curved(TriangleMesh mesh, int times);

}  // namespace musclebench
