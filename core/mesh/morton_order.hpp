#pragma once

#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// An order of points in which those that follow each other are close together: along a curve that fills space
/// (Morton's), or as they are where that way is shorter. The points may be anything, also not finite.
std::vector<int> morton_order(std::span<const Vec3> points);

/// Numbers triangles and vertices so that those that are close together lie close together in memory; the surface, its
/// windings included, is as before.
void sort_in_morton_order(TriangleMesh& mesh);

}  // namespace musclebench
