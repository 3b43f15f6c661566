#include "core/bvh/nearby_triangles.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "core/base/grid_index.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

constexpr double most_cells = 64;  ///< along an axis

/// Marks the cells of a grid that are within some distance of a point.
class MarkedCells {
 public:
  MarkedCells(std::span<const Vec3> points, double distance_m) : m_box(bounding_box(points)) {
    m_box.min() -= Vec3::Constant(distance_m);
    m_box.max() += Vec3::Constant(distance_m);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double size_m = m_box.sizes()[static_cast<Eigen::Index>(axis)];
      const double cells = distance_m > 0 ? std::clamp(size_m / distance_m, 1.0, most_cells) : most_cells;
      m_cells.count[axis] = static_cast<std::size_t>(cells);
      m_per_m[static_cast<Eigen::Index>(axis)] = size_m > 0 ? std::floor(cells) / size_m : 0;
    }
    m_marked.assign(m_cells.size(), 0);
    for (const Vec3& point : points) {
      for_each_cell({point - Vec3::Constant(distance_m), point + Vec3::Constant(distance_m)}, [&](std::size_t cell) {
        m_marked[cell] = 1;
        return false;
      });
    }
  }

  [[nodiscard]] bool meets(const Eigen::AlignedBox3d& box) const {
    return m_box.intersects(box) && for_each_cell(box, [&](std::size_t cell) { return m_marked[cell] != 0; });
  }

 private:
  /// Until `visit` returns true.
  template <typename Visit>
  bool for_each_cell(const Eigen::AlignedBox3d& box, const Visit& visit) const {
    std::array<std::size_t, 3> from{};
    std::array<std::size_t, 3> to{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      from[axis] = cell_along(box.min(), axis);
      to[axis] = cell_along(box.max(), axis);
    }
    for (std::size_t k = from[2]; k <= to[2]; ++k) {
      for (std::size_t j = from[1]; j <= to[1]; ++j) {
        for (std::size_t i = from[0]; i <= to[0]; ++i) {
          if (visit(m_cells.index(i, j, k))) return true;
        }
      }
    }
    return false;
  }
  [[nodiscard]] std::size_t cell_along(const Vec3& point, std::size_t axis) const {
    const auto a = static_cast<Eigen::Index>(axis);
    const double cell = (point[a] - m_box.min()[a]) * m_per_m[a];
    return static_cast<std::size_t>(std::clamp(cell, 0.0, static_cast<double>(m_cells.count[axis] - 1)));
  }

  Eigen::AlignedBox3d m_box;
  GridIndex m_cells;
  Vec3 m_per_m;
  std::vector<char> m_marked;
};

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

NearbyTriangles::NearbyTriangles(const TriangleMesh& mesh, std::span<const Vec3> points, double margin_m)
    : m_margin_m(margin_m) {
  if (points.empty()) return;
  // Far more than rounding: a triangle at the margin itself counts.
  const Eigen::AlignedBox3d box = bounding_box(points);
  const double reach_m = margin_m + 1e-9 * (margin_m + box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).sum());
  const MarkedCells cells(points, reach_m);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Eigen::AlignedBox3d of_triangle;
    for (const int vertex : mesh.triangles[t]) of_triangle.extend(mesh.vertices[static_cast<std::size_t>(vertex)]);
    if (cells.meets(of_triangle)) m_triangles.push_back(static_cast<int>(t));
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
