#include <algorithm>
#include <cstddef>
#include <numeric>

#include "core/mesh_files/polygon_mesh.hpp"

namespace musclebench {

namespace {

using FlatPolygon = std::vector<Eigen::Vector2d>;

/// The corners relative to the first, in units of the polygon's extent, so that neither small faces far from the origin
/// nor huge ones lose digits; empty where all are at one position.
std::vector<Vec3> scaled_corners(const PolygonMesh& mesh, int polygon) {
  std::vector<Vec3> corners;
  const Vec3& first = mesh.vertices[mesh.corners[mesh.first_corner[polygon]]];
  double extent_m = 0;
  for (int corner = mesh.first_corner[polygon]; corner < mesh.end_corner(polygon); ++corner) {
    corners.push_back(mesh.vertices[mesh.corners[corner]] - first);
    extent_m = std::max(extent_m, corners.back().cwiseAbs().maxCoeff());
  }
  if (!(extent_m > 0)) return {};
  for (Vec3& corner : corners) corner /= extent_m;
  return corners;
}

/// The polygon seen along the axis next to Newell's normal, counter-clockwise; empty where it has no area.
FlatPolygon flattened(const PolygonMesh& mesh, int polygon) {
  const std::vector<Vec3> corners = scaled_corners(mesh, polygon);
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) normal += corners[i].cross(corners[(i + 1) % corners.size()]);
  int along = 0;
  if (!(normal.cwiseAbs().maxCoeff(&along) > 0)) return {};
  const double side = normal[along] > 0 ? 1 : -1;
  FlatPolygon flat;
  for (const Vec3& corner : corners) flat.emplace_back(side * corner[(along + 1) % 3], corner[(along + 2) % 3]);
  return flat;
}

/// Twice the area of a triangle, positive where it runs counter-clockwise.
double doubled_area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Whether a triangle of three corners that follow each other can be cut off: none of the others is in it. One at the
/// position of a corner of the triangle, as where a slit joins a hole with the outside, is not in the way.
bool is_ear(const FlatPolygon& points, const std::vector<int>& left, const Triangle& triangle) {
  const Eigen::Vector2d& a = points[triangle[0]];
  const Eigen::Vector2d& b = points[triangle[1]];
  const Eigen::Vector2d& c = points[triangle[2]];
  if (!(doubled_area(a, b, c) > 0)) return false;
  return std::ranges::none_of(left, [&](int corner) {
    const Eigen::Vector2d& point = points[corner];
    return point != a && point != b && point != c && doubled_area(a, b, point) >= 0 && doubled_area(b, c, point) >= 0 &&
           doubled_area(c, a, point) >= 0;
  });
}

/// The triangles of a simple polygon, by cutting off ears (Meisters 1975), a fan for a convex one; empty where there is
/// no ear, as may be where the polygon crosses itself.
std::vector<Triangle> cut(const FlatPolygon& points) {
  std::vector<int> left(points.size());
  std::iota(left.begin(), left.end(), 0);
  std::vector<Triangle> triangles;
  std::size_t at = 1;
  for (std::size_t tried = 0; left.size() > 3 && tried < left.size();) {
    const std::size_t count = left.size();
    const Triangle triangle{left[(at + count - 1) % count], left[at], left[(at + 1) % count]};
    if (is_ear(points, left, triangle)) {
      triangles.push_back(triangle);
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
      tried = 0;
    } else {
      ++at;
      ++tried;
    }
    at %= left.size();
  }
  if (left.size() != 3 || doubled_area(points[left[0]], points[left[1]], points[left[2]]) < 0) return {};
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

void add_fan(const PolygonMesh& mesh, int polygon, std::vector<Triangle>& triangles) {
  const int* corners = mesh.corners.data() + mesh.first_corner[polygon];
  const int count = mesh.end_corner(polygon) - mesh.first_corner[polygon];
  for (int k = 1; k + 1 < count; ++k) {
    triangles.push_back({corners[0], corners[k], corners[k + 1]});
  }
}

}  // namespace

std::vector<Triangle> split_into_triangles(const PolygonMesh& mesh) {
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.polygons());
  for (int polygon = 0; polygon < mesh.polygons(); ++polygon) {
    const bool is_large = mesh.end_corner(polygon) - mesh.first_corner[polygon] > 3;
    const std::vector<Triangle> pieces = is_large ? cut(flattened(mesh, polygon)) : std::vector<Triangle>{};
    if (pieces.empty()) {
      add_fan(mesh, polygon, triangles);
    }
    const int* corners = mesh.corners.data() + mesh.first_corner[polygon];
    for (const Triangle& piece : pieces) {
      triangles.push_back({corners[piece[0]], corners[piece[1]], corners[piece[2]]});
    }
  }
  return triangles;
}

}  // namespace musclebench
