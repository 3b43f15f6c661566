#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace musclebench {

/// A point (metres), a displacement (metres) or a direction (unit length) in three dimensions.
using Vec3 = Eigen::Vector3d;
/// A 3 x 3 matrix, such as a rotation.
using Mat3 = Eigen::Matrix3d;

/// Vertex indices of one triangle, counter-clockwise seen from outside.
using Triangle = std::array<int, 3>;

/// A triangle surface with positions in metres. Triangles index into `vertices`. The surface may be open and its
/// triangles may be wound inconsistently. `repair_mesh` repairs what it can.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

}  // namespace musclebench
