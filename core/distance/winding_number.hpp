#pragma once

#include <span>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The winding number of triangles about a point, all in metres in one frame: of a closed surface wound outwards 1
/// inside and 0 outside; of an open one anything between. The sum of all signed solid angles over 4 pi, as
/// SolidAngleSum has it, in SIMD lanes; the same bits for every kind of SIMD.
double winding_number(std::span<const Triangle> triangles, std::span<const Vec3> vertices, const Vec3& point);

}  // namespace musclebench
