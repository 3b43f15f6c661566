#pragma once

#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Indices of the points in Morton (Z-curve) order, in which successive points are close together; the original order
/// where the path through it is shorter. Points that are not finite count as at the lower corner of the others.
std::vector<int> morton_order(std::span<const Vec3> points);

/// Renumbers triangles (by their middles) and vertices (by first use), so that what is close together in space is close
/// together in memory. The surface and its winding stay the same.
void sort_in_morton_order(TriangleMesh& mesh);

}  // namespace musclebench
