#pragma once

#include <cstddef>

#include "backends/sdf/build/octree_cells.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// A proven bound, in metres: outside the surface and farther than this from it the polynomial of a leaf (its `terms`
/// coefficients in `fit`) is not negative. At least `least_m`, at which refinement stops. `surface`: of the samples.
double sign_error_distance_m(const SignedSurface& surface, const OctreeCell& cell, const PolynomialFit& fit,
                             std::size_t terms, double least_m);

}  // namespace musclebench
