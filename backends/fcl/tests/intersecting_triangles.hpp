#pragma once

#include <array>
#include <cstddef>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "core/mesh/rigid_motion.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

using TriangleCorners = std::array<Vec3, 3>;
using PairSet = std::set<std::pair<int, int>>;

inline double six_volumes(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Whether the segment p q crosses the triangle, by the signs of the volumes that they span. Not for touching ones.
inline bool segment_crosses(const Vec3& p, const Vec3& q, const TriangleCorners& t) {
  if ((six_volumes(t[0], t[1], t[2], p) > 0) == (six_volumes(t[0], t[1], t[2], q) > 0)) {
    return false;
  }
  const bool first = six_volumes(p, q, t[0], t[1]) > 0;
  return (six_volumes(p, q, t[1], t[2]) > 0) == first && (six_volumes(p, q, t[2], t[0]) > 0) == first;
}

/// Two triangles in general position intersect where an edge of one crosses the other.
inline bool triangles_intersect(const TriangleCorners& a, const TriangleCorners& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (segment_crosses(a[i], a[(i + 1) % 3], b) || segment_crosses(b[i], b[(i + 1) % 3], a)) {
      return true;
    }
  }
  return false;
}

inline std::vector<TriangleCorners> corners_of(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  std::vector<TriangleCorners> all;
  for (const Triangle& t : triangles) {
    all.push_back({vertices[static_cast<std::size_t>(t[0])], vertices[static_cast<std::size_t>(t[1])],
                   vertices[static_cast<std::size_t>(t[2])]});
  }
  return all;
}

inline std::vector<Eigen::AlignedBox3d> boxes_of(const std::vector<TriangleCorners>& triangles) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const TriangleCorners& t : triangles) {
    boxes.emplace_back(Vec3(t[0].cwiseMin(t[1]).cwiseMin(t[2])), Vec3(t[0].cwiseMax(t[1]).cwiseMax(t[2])));
  }
  return boxes;
}

/// All pairs (muscle triangle, bone triangle) that intersect, each against each. Knows nothing of FCL.
inline PairSet intersecting_pairs(std::span<const Vec3> positions, std::span<const Triangle> muscle_triangles,
                                  const TriangleMesh& bone, const RigidMotion& pose) {
  std::vector<Vec3> moved;
  for (const Vec3& vertex : bone.vertices) {
    moved.push_back(pose.apply(vertex));
  }
  const auto muscle = corners_of(positions, muscle_triangles);
  const auto bones = corners_of(moved, bone.triangles);
  const auto muscle_boxes = boxes_of(muscle);
  const auto bone_boxes = boxes_of(bones);
  PairSet pairs;
  for (std::size_t i = 0; i < muscle.size(); ++i) {
    for (std::size_t j = 0; j < bones.size(); ++j) {
      if (muscle_boxes[i].intersects(bone_boxes[j]) && triangles_intersect(muscle[i], bones[j])) {
        pairs.emplace(static_cast<int>(i), static_cast<int>(j));
      }
    }
  }
  return pairs;
}

}  // namespace musclebench
