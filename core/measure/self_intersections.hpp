#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Counts the triangles that pass through another triangle of the same surface: a muscle that is folded through itself.
/// Decided without rounding errors. Two triangles that share a vertex intersect where they pass through each other
/// elsewhere; two that share an edge never do. What only touches, or lies in one plane, does not count.
/// Positions must be finite.
int count_self_intersecting_triangles(const TriangleMesh& mesh);

}  // namespace musclebench
