#pragma once

#include "core/effects/no_passage/path_spheres.hpp"

namespace musclebench {

/// What directions tell of two triangles on straight paths.
struct ApartAlongAxes {
  double start_m = 0;       ///< how far apart they are at least where the paths start, or 0
  bool stay_apart = false;  ///< whether one direction separates them by more than asked for all the way
};

/// Along both normals and what is across each side in its triangle's plane: all that separates flat neighbours and
/// surfaces that lie on each other. Both triangles are relative to one origin.
ApartAlongAxes apart_along_axes(const TrianglePath& first, const TrianglePath& second, double least_m);

}  // namespace musclebench
