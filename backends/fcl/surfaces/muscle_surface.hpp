#pragma once

#include <vector>

#include "core/mesh/body.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A muscle as FCL gets it: the triangles that have an area, since the others are no surface, and some of FCL's volumes
/// around them are not numbers. Their edges belong to their neighbours too, so no contact is lost.
struct MuscleSurface {
  int first_node = 0;
  std::vector<int> triangles;             ///< of the mesh of all muscles
  std::vector<Triangle> local_triangles;  ///< the same, their nodes counted from the muscle's first
  std::vector<Vec3> rest_positions;       ///< of the muscle's nodes
};

/// Throws InputError that names `what` where no triangle has an area.
MuscleSurface muscle_surface(const TriangleMesh& mesh, const Body& muscle, const char* what);

/// All of a mesh.
MuscleSurface muscle_surface(const TriangleMesh& mesh, const char* what);

}  // namespace musclebench
