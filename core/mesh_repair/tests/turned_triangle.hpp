#pragma once

#include <utility>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Turns the triangle's outside in.
inline void turn(Triangle& triangle) { std::swap(triangle[1], triangle[2]); }

}  // namespace musclebench
