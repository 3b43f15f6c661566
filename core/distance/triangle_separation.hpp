#pragma once

#include <array>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A triangle by its vertices' indices and positions.
struct IndexedTriangle {
  const Triangle& vertices;
  const std::array<Vec3, 3>& corners;
};

/// Whether a plane proves that two triangles have no point in common but the vertices that they share, and not by
/// rounding: one of them lies on one side, the other corners of the other are farther than `margin_m` on the other
/// side. `margin_m` is positive, and far more than the rounding of a triangle's size. False proves nothing; it is the
/// answer for triangles that share all three vertices.
bool surely_apart(const IndexedTriangle& one, const IndexedTriangle& other, double margin_m);

}  // namespace musclebench
