#pragma once

#include <algorithm>
#include <vector>

#include "core/contact/collision_backend.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

inline Bone bone_of(const TriangleMesh& mesh) { return {"shape", {mesh, false, {}}}; }

inline TriangleMesh moved(TriangleMesh mesh, const RigidMotion& motion) {
  for (Vec3& vertex : mesh.vertices) vertex = motion.apply(vertex);
  return mesh;
}

inline TriangleMesh moved(const TriangleMesh& mesh, const Vec3& displacement) {
  return moved(mesh, RigidMotion{Mat3::Identity(), displacement});
}

inline TriangleMesh scaled(TriangleMesh mesh, double factor) {
  for (Vec3& vertex : mesh.vertices) vertex *= factor;
  return mesh;
}

inline void append(TriangleMesh& mesh, const TriangleMesh& more) {
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const Triangle& t : more.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

inline RigidMotion some_motion() {
  RigidMotion motion = RigidMotion::about_axis(Vec3(1, 2, -0.5).normalized(), {0.3, -1, 2}, 1.1);
  motion.translation_m += Vec3(0.7, -2, 5);
  return motion;
}

/// A roof along y: its ridge at z = 0 from y = -length to length, its base at z = -height from x = -half_width to
/// half_width.
inline TriangleMesh make_roof(double half_width, double height, double length) {
  TriangleMesh mesh;
  for (const double y : {-length, length}) {
    mesh.vertices.insert(mesh.vertices.end(), {{-half_width, y, -height}, {half_width, y, -height}, {0, y, 0}});
  }
  mesh.triangles = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}, {2, 5, 3}, {2, 3, 0}};
  return mesh;
}

/// A pyramid on a square base at z = -height, its tip at the origin.
inline TriangleMesh make_spike(double half_width, double height) {
  TriangleMesh mesh;
  mesh.vertices = {{-half_width, -half_width, -height},
                   {half_width, -half_width, -height},
                   {half_width, half_width, -height},
                   {-half_width, half_width, -height},
                   {0, 0, 0}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return mesh;
}

/// The outline (x, z; counter-clockwise seen from -y) along y from -1 to 1, in `rows` rows; the ends are fans around
/// `hub`, a point from which the whole outline is seen.
inline TriangleMesh extruded(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& hub, int rows) {
  TriangleMesh mesh;
  const int n = static_cast<int>(outline.size());
  for (int row = 0; row <= rows; ++row) {
    for (const Eigen::Vector2d& p : outline) mesh.vertices.emplace_back(p.x(), -1 + 2.0 * row / rows, p.y());
  }
  for (const double y : {-1.0, 1.0}) mesh.vertices.emplace_back(hub.x(), y, hub.y());
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    for (int row = 0; row < rows; ++row) {
      mesh.triangles.push_back({row * n + i, row * n + next, (row + 1) * n + next});
      mesh.triangles.push_back({row * n + i, (row + 1) * n + next, (row + 1) * n + i});
    }
    mesh.triangles.push_back({next, i, (rows + 1) * n});
    mesh.triangles.push_back({rows * n + i, rows * n + next, (rows + 1) * n + 1});
  }
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// A block with a groove along y, 45 degrees to both sides, its valley line at z = 0. 196 triangles.
inline TriangleMesh grooved_block() {
  return extruded({{-2, -2}, {2, -2}, {2, 1}, {1, 1}, {0, 0}, {-1, 1}, {-2, 1}}, {0, -1}, 13);
}

/// What fills the groove. 97 nodes.
inline TriangleMesh groove_filling() {
  return extruded({{0, 0}, {0.5, 0.5}, {1, 1}, {-1, 1}, {-0.5, 0.5}}, {0, 0.7}, 18);
}

inline std::vector<int> all_nodes(std::size_t count) {
  std::vector<int> nodes(count);
  for (std::size_t i = 0; i < count; ++i) nodes[i] = static_cast<int>(i);
  return nodes;
}

}  // namespace musclebench
