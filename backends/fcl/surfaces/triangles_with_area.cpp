#include "backends/fcl/surfaces/triangles_with_area.hpp"

#include <Eigen/Geometry>

#include "core/base/input_error.hpp"

namespace musclebench {

std::vector<int> triangles_with_area(const TriangleMesh& mesh, std::size_t first, std::size_t last, const char* what) {
  std::vector<int> kept;
  for (std::size_t t = first; t < last; ++t) {
    const auto& [ia, ib, ic] = mesh.triangles[t];
    const Vec3& a = mesh.vertices[static_cast<std::size_t>(ia)];
    const Vec3 ab = mesh.vertices[static_cast<std::size_t>(ib)] - a;
    const Vec3 ac = mesh.vertices[static_cast<std::size_t>(ic)] - a;
    if (ab.cross(ac).squaredNorm() > 0) kept.push_back(static_cast<int>(t));
  }
  if (kept.empty()) {
    throw InputError(what, "none of its triangles has an area; give a surface");
  }
  return kept;
}

}  // namespace musclebench
