#include "backends/fcl/surfaces/muscle_surface.hpp"

#include <Eigen/Geometry>

#include "core/base/input_error.hpp"

namespace musclebench {

MuscleSurface muscle_surface(const TriangleMesh& mesh, const Body& muscle, const char* what) {
  MuscleSurface surface;
  surface.first_node = muscle.first_node;
  for (std::size_t t = muscle.first_triangle; t < muscle.last_triangle; ++t) {
    const auto& [ia, ib, ic] = mesh.triangles[t];
    const Vec3& a = mesh.vertices[static_cast<std::size_t>(ia)];
    const Vec3 ab = mesh.vertices[static_cast<std::size_t>(ib)] - a;
    const Vec3 ac = mesh.vertices[static_cast<std::size_t>(ic)] - a;
    if (!(ab.cross(ac).squaredNorm() > 0)) continue;
    surface.triangles.push_back(static_cast<int>(t));
    surface.local_triangles.push_back({ia - muscle.first_node, ib - muscle.first_node, ic - muscle.first_node});
  }
  if (surface.triangles.empty()) {
    throw InputError(muscle.name.empty() ? what : what + (" '" + muscle.name + "'"),
                     "none of its triangles has an area; give a surface");
  }
  surface.rest_positions.assign(mesh.vertices.begin() + muscle.first_node, mesh.vertices.begin() + muscle.last_node);
  return surface;
}

MuscleSurface muscle_surface(const TriangleMesh& mesh, const char* what) {
  return muscle_surface(mesh, {"", 0, static_cast<int>(mesh.vertices.size()), 0, mesh.triangles.size()}, what);
}

}  // namespace musclebench
