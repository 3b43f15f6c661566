#pragma once

#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What cotangents of a surface's angles are limited to; the least is that of an angle without a sine, too.
struct CotangentLimits {
  double least;
  double most;
};

/// The function on a surface whose Laplacian is 0, but for `sources`, with cotangent weights (Pinkall and Polthier
/// 1993). `values`: by vertex, those that are known; NaN: to be found. `sources`: by vertex, what flows in there;
/// empty: nothing. What flows between two vertices is the sum of their two opposite cotangents times the difference,
/// twice that of linear finite elements.
///
/// Vertices without triangles stay as they are. Each component needs a known value; the result is empty where the
/// solver finds that it has none.
std::vector<double> solve_on_surface(const TriangleMesh& mesh, std::vector<double> values,
                                     std::span<const double> sources, const CotangentLimits& limits);

}  // namespace musclebench
