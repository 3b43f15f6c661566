#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace musclebench {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Vertex indices of one triangle, counter-clockwise seen from outside.
using Triangle = std::array<int, 3>;

/// A triangle surface: positions in metres, triangles index into them. It need be neither closed nor consistently
/// wound: `check_mesh` reports, `repair_mesh` mends what it can.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

}  // namespace musclebench
