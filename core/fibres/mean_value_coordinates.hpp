#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Mean value coordinates of `point` with respect to the vertices of a triangle surface (Ju, Schaefer and Warren 2005):
/// one weight a vertex, with which a function given at the vertices is carried to the point. Those of the published
/// form, then moved by the least multiple of an affine function that makes them reproduce every affine function to
/// rounding, as reproducing kernels are (Liu, Jun and Zhang 1995): what the form loses to rounding, to triangles seen
/// edge-on and to an open surface is given back. Their sum is 1. They may be negative where the surface is not convex.
///
/// `point` is finite and not on the surface, where the weights of one triangle are the answer. Empty where the vertices
/// lie in a plane, as seen from the point.
std::vector<double> mean_value_coordinates(const TriangleMesh& surface, const Vec3& point);

}  // namespace musclebench
