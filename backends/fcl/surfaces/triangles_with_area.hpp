#pragma once

#include <cstddef>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The indices of those triangles from `first` to `last` (exclusive) that have an area: the others are no surface, and
/// some of FCL's volumes around them are not numbers. Their edges belong to their neighbours too, so no contact is
/// lost. Throws InputError that names `what` where there are none.
std::vector<int> triangles_with_area(const TriangleMesh& mesh, std::size_t first, std::size_t last, const char* what);

}  // namespace musclebench
