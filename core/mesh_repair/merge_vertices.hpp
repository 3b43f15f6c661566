#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Lets the triangles use the first of all vertices at one position; `first` are those of `first_at_position`. Returns
/// how many vertices lost their triangles to an earlier one. All vertices stay.
int merge_vertices(TriangleMesh& mesh, const std::vector<int>& first);

/// Drops triangles of which two corners are one vertex. Returns how many.
int drop_collapsed_triangles(TriangleMesh& mesh);

/// Drops the triangles that are marked; the others keep their order. Returns how many.
int drop_marked_triangles(TriangleMesh& mesh, const std::vector<char>& is_dropped);

/// Drops vertices that no triangle uses; the others keep their order. Returns the new index of each, -1 for a dropped
/// one.
std::vector<int> drop_unreferenced_vertices(TriangleMesh& mesh);

}  // namespace musclebench
