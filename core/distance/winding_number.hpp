#pragma once

#include <span>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The exact winding number of a surface about a point: the sum of the signed solid angles of all triangles, divided by
/// 4 pi (Jacobson et al. 2013). For a closed surface that is wound outwards it is 1 inside and 0 outside. For an open
/// surface it varies between them.
///
/// `vertices` and `point` are in metres, in one frame. The cost grows with the number of triangles. The kernel uses
/// SIMD, and the bits are the same on every CPU. Safe from several threads.
double winding_number(std::span<const Triangle> triangles, std::span<const Vec3> vertices, const Vec3& point);

}  // namespace musclebench
