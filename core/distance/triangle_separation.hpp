#pragma once

#include <array>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A triangle by its vertices' indices and positions.
struct IndexedTriangle {
  const Triangle& vertices;
  const std::array<Vec3, 3>& corners;
};

/// Separating-plane test with a margin: true proves that two triangles have no point in common except the vertices that
/// they share. One triangle lies on one side of the plane, the unshared corners of the other are more than `margin_m`
/// away on the other side. `margin_m` is positive and far larger than rounding errors. False proves nothing; triangles
/// that share all three vertices give false.
bool surely_apart(const IndexedTriangle& one, const IndexedTriangle& other, double margin_m);

}  // namespace musclebench
