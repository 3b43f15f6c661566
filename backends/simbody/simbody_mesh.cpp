#include "backends/simbody/simbody_mesh.hpp"

#include <simbody/SimTKmath.h>
#include <stdexcept>

namespace musclebench {

struct SimbodyMesh::Mesh {
  SimTK::ContactGeometry::TriangleMesh geometry;
};

namespace {

SimTK::Array_<SimTK::Vec3> to_simbody(const std::vector<std::array<double, 3>>& vertices) {
  SimTK::Array_<SimTK::Vec3> made;
  for (const auto& [x, y, z] : vertices) made.push_back(SimTK::Vec3(x, y, z));
  return made;
}

}  // namespace

SimbodyMesh::SimbodyMesh(const std::vector<std::array<double, 3>>& vertices, const std::vector<int>& corners) {
  try {
    m_mesh.reset(new Mesh{SimTK::ContactGeometry::TriangleMesh(
        to_simbody(vertices), SimTK::Array_<int>(corners.begin(), corners.end()), false)});
  } catch (const std::exception& refused) {
    throw std::runtime_error(refused.what());
  }
}

SimbodyMesh::~SimbodyMesh() = default;

SimbodyMesh::Nearest SimbodyMesh::nearest(const std::array<double, 3>& point) const {
  bool inside = false;
  SimTK::UnitVec3 normal;
  const SimTK::Vec3 found =
      m_mesh->geometry.findNearestPoint(SimTK::Vec3(point[0], point[1], point[2]), inside, normal);
  return {{found[0], found[1], found[2]}, inside};
}

std::size_t SimbodyMesh::bytes() const {
  const auto faces = static_cast<std::size_t>(m_mesh->geometry.getNumFaces());
  const auto edges = static_cast<std::size_t>(m_mesh->geometry.getNumEdges());
  const auto vertices = static_cast<std::size_t>(m_mesh->geometry.getNumVertices());
  constexpr std::size_t ints = 6 * sizeof(int) + sizeof(double) + 3 * sizeof(double);  // a face
  constexpr std::size_t node = sizeof(SimTK::OrientedBoundingBox) + 4 * sizeof(void*);
  return faces * (ints + 2 * node) + edges * 4 * sizeof(int) + vertices * 7 * sizeof(double);
}

std::string SimbodyMesh::version() {
  int major = 0;
  int minor = 0;
  int build = 0;
  SimTK_version_simmath(&major, &minor, &build);
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(build);
}

}  // namespace musclebench
