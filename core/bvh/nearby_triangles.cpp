#include "core/bvh/nearby_triangles.hpp"

#include <cassert>

namespace musclebench {

namespace {

TriangleMesh part_of(const TriangleMesh& mesh, const std::vector<int>& triangles) {
  TriangleMesh part;
  for (const int triangle : triangles) {
    const auto first = static_cast<int>(part.vertices.size());
    for (const int vertex : mesh.triangles[static_cast<std::size_t>(triangle)]) {
      part.vertices.push_back(mesh.vertices[static_cast<std::size_t>(vertex)]);
    }
    part.triangles.push_back({first, first + 1, first + 2});
  }
  return part;
}

}  // namespace

NearbyTriangles::NearbyTriangles(const TriangleMesh& mesh, const Eigen::AlignedBox3d& points, double margin_m)
    : m_margin_m(margin_m) {
  if (points.isEmpty()) return;
  // Far more than rounding: a triangle at the margin itself counts.
  const double grown_m = margin_m + 1e-9 * (margin_m + points.min().cwiseAbs().cwiseMax(points.max().cwiseAbs()).sum());
  const Vec3 lower = points.min() - Vec3::Constant(grown_m);
  const Vec3 upper = points.max() + Vec3::Constant(grown_m);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3& a = mesh.vertices[static_cast<std::size_t>(i)];
    const Vec3& b = mesh.vertices[static_cast<std::size_t>(j)];
    const Vec3& c = mesh.vertices[static_cast<std::size_t>(k)];
    if ((a.cwiseMin(b).cwiseMin(c).array() <= upper.array()).all() &&
        (a.cwiseMax(b).cwiseMax(c).array() >= lower.array()).all()) {
      m_triangles.push_back(static_cast<int>(t));
    }
  }
  if (!m_triangles.empty()) m_tree.emplace(part_of(mesh, m_triangles));
}

std::optional<ClosestPoint> NearbyTriangles::closest_point(const Vec3& point, double max_distance_m) const {
  assert(max_distance_m <= m_margin_m);
  if (!m_tree) return std::nullopt;
  std::optional<ClosestPoint> closest = m_tree->closest_point(point, max_distance_m);
  if (closest) closest->triangle = m_triangles[static_cast<std::size_t>(closest->triangle)];
  return closest;
}

}  // namespace musclebench
