#pragma once

#include <string>
#include <vector>

#include "core/fibres/volume_potential.hpp"

namespace musclebench {

/// A fibre of a muscle at rest, from the origin to the insertion. Its ends lie on triangles of the two areas, all other
/// points inside the muscle, at equal distances along it.
struct FibrePath {
  std::vector<Vec3> points;
  int origin_triangle = -1;
  int insertion_triangle = -1;
};

struct FibrePaths {
  std::vector<FibrePath> fibres;
  int lost = 0;  ///< asked for, and ended away from the areas
};

/// Streamlines of the potential's flow from points that share the origin area evenly, `count` at most, each of
/// `segments` segments.
FibrePaths trace_fibres(const VolumePotential& potential, const TriangleMesh& muscle, const SignedSurface& surface,
                        const FibreAreas& areas, int count, int segments);

}  // namespace musclebench
