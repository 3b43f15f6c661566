#pragma once

#include <string>
#include <vector>

#include "core/base/parameters.hpp"
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

/// The area of the triangles beside an edge (at most one on each side) over the square of its length, relative to that
/// of an edge between equilateral triangles: 1 there, a half at a border, and at least 1e-6, so that it divides.
///
/// With it a compliance is one of the surface. Springs whose stiffness is multiplied by it are a
/// membrane with one Young's modulus (Van Gelder 1998, "Approximate simulation of elastic membranes by triangulated
/// spring meshes"). Hinges whose stiffness is divided by it are a plate with one bending stiffness (Grinspun and others
/// 2003, "Discrete shells"). Both are exact for equilateral triangles only: where triangles are seven times as long as
/// wide, a tube stretches by 23 % in place of 33 %, and without this by 4 %.
double relative_area(const TriangleMesh& mesh, const SurfaceEdge& edge);
/// The parameter of an effect with a compliance: whether it is one of the surface. `constraint`: edge or hinge.
ParameterSpec per_area_flag(const std::string& constraint);

}  // namespace musclebench
