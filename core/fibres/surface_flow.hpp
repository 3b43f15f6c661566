#pragma once

#include <array>
#include <vector>

#include "core/fibres/end_nodes.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// How a muscle's fibres run along its surface at rest, by triangle: the direction towards the insertion, and as length
/// the share of all fibres that cross a line of one metre across them, 1/m. As a flow it is even in at the nodes of the
/// origin and even out at those of the insertion, by the area about each, and nowhere else: so every section between
/// them is crossed by all fibres, once. Empty where an end has no nodes, or no part of the surface joins both.
///
/// Solved with linear finite elements, that is, with cotangent weights: where all fibres pull alike, their pulls on a
/// node between the ends are balanced along a flat surface, to rounding. A triangle whose height is less than 1e-5 of
/// its longest side has no flow, as if it were a hole.
std::vector<Vec3> surface_flow(const TriangleMesh& muscle, const EndNodes& ends);

/// The gradients of the three barycentric coordinates of a triangle, 1/m; all 0 where it has no area.
std::array<Vec3, 3> barycentric_gradients(const TriangleMesh& mesh, const Triangle& triangle);

}  // namespace musclebench
