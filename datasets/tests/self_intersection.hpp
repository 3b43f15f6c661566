#pragma once

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Number of pairs of an edge and a triangle without a common vertex that cross.
int count_self_intersections(const TriangleMesh& mesh);

}  // namespace musclebench
