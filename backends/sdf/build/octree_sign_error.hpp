#pragma once

#include <cstddef>

#include "backends/sdf/build/octree_cells.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// Outside the surface and farther than this from it, in metres, the polynomial of a leaf (its `terms` coefficients in
/// `fit`) is not negative: proven. At least `least_m`, below which nothing is examined more closely. `surface` is what
/// the cell was sampled from.
double sign_error_distance_m(const SignedSurface& surface, const OctreeCell& cell, const PolynomialFit& fit,
                             std::size_t terms, double least_m);

}  // namespace musclebench
