#include "core/mesh/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "core/base/portable_math.hpp"

namespace musclebench {

namespace {

void require(bool holds, const char* problem) {
  if (!holds) {
    throw std::invalid_argument(problem);
  }
}

bool is_positive_size(double size_m) { return std::isfinite(size_m) && size_m > 0; }

TriangleMesh unit_icosahedron() {
  const double g = std::numbers::phi;
  TriangleMesh mesh;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Vec3& vertex : mesh.vertices) {
    vertex.normalize();
  }
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return mesh;
}

/// Splits each triangle in four; new vertices are projected onto the unit sphere.
void split_on_unit_sphere(TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<int>(mesh.vertices.size()));
    if (is_new) {
      mesh.vertices.emplace_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
    }
    return entry->second;
  };
  std::vector<Triangle> split;
  split.reserve(4 * mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const int ab = middle(a, b);
    const int bc = middle(b, c);
    const int ca = middle(c, a);
    split.insert(split.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  mesh.triangles = std::move(split);
}

void add_quad(TriangleMesh& mesh, int a, int b, int c, int d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

}  // namespace

TriangleMesh make_sphere(double radius_m, int subdivisions) {
  require(is_positive_size(radius_m), "make_sphere: radius_m must be positive and finite");
  require(subdivisions >= 0, "make_sphere: subdivisions must be at least 0");
  TriangleMesh mesh = unit_icosahedron();
  for (int round = 0; round < subdivisions; ++round) {
    split_on_unit_sphere(mesh);
  }
  for (Vec3& vertex : mesh.vertices) {
    vertex *= radius_m;
  }
  return mesh;
}

TriangleMesh make_box(const Vec3& half_extents_m, int cells_per_edge) {
  require(half_extents_m.allFinite() && half_extents_m.minCoeff() > 0,
          "make_box: half_extents_m must be positive and finite");
  require(cells_per_edge >= 1, "make_box: cells_per_edge must be at least 1");
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> known;
  const auto vertex_at = [&](const std::array<int, 3>& grid_point) {
    const auto [entry, is_new] = known.try_emplace(grid_point, static_cast<int>(mesh.vertices.size()));
    if (is_new) {
      Vec3 position;
      for (int axis = 0; axis < 3; ++axis) {
        position[axis] = half_extents_m[axis] * (2.0 * grid_point[axis] - cells_per_edge) / cells_per_edge;
      }
      mesh.vertices.push_back(position);
    }
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool is_upper : {false, true}) {
      // The two other axes, in the order that makes the cells counter-clockwise seen from outside.
      const int u = (axis + (is_upper ? 1 : 2)) % 3;
      const int v = (axis + (is_upper ? 2 : 1)) % 3;
      const auto corner = [&](int i, int j) {
        std::array<int, 3> grid_point{};
        grid_point[axis] = is_upper ? cells_per_edge : 0;
        grid_point[u] = i;
        grid_point[v] = j;
        return vertex_at(grid_point);
      };
      for (int i = 0; i < cells_per_edge; ++i) {
        for (int j = 0; j < cells_per_edge; ++j) {
          add_quad(mesh, corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
        }
      }
    }
  }
  return mesh;
}

TriangleMesh make_capsule(double radius_m, double half_length_m, int segments) {
  require(is_positive_size(radius_m), "make_capsule: radius_m must be positive and finite");
  require(std::isfinite(half_length_m) && half_length_m >= 0, "make_capsule: half_length_m must be finite, at least 0");
  require(segments >= 3, "make_capsule: segments must be at least 3");
  constexpr double pi = std::numbers::pi;
  const int rings_per_cap = std::max(1, segments / 4);
  const double segment_m = 2 * pi * radius_m / segments;
  const int rows = half_length_m > 0 ? std::max(1, static_cast<int>(std::lround(2 * half_length_m / segment_m))) : 0;

  TriangleMesh mesh;
  mesh.vertices.emplace_back(0, 0, -half_length_m - radius_m);
  const auto add_ring = [&](double ring_radius_m, double z_m) {
    for (int i = 0; i < segments; ++i) {
      const double angle = 2 * pi * i / segments;
      mesh.vertices.emplace_back(ring_radius_m * portable::cos(angle), ring_radius_m * portable::sin(angle), z_m);
    }
  };
  for (int ring = 1; ring <= rings_per_cap; ++ring) {
    const double latitude = pi / 2 * ring / rings_per_cap;
    add_ring(radius_m * portable::sin(latitude), -half_length_m - radius_m * portable::cos(latitude));
  }
  for (int row = 1; row <= rows; ++row) {
    add_ring(radius_m, half_length_m * (2.0 * row - rows) / rows);
  }
  for (int ring = rings_per_cap - 1; ring >= 1; --ring) {
    const double latitude = pi / 2 * ring / rings_per_cap;
    add_ring(radius_m * portable::sin(latitude), half_length_m + radius_m * portable::cos(latitude));
  }
  mesh.vertices.emplace_back(0, 0, half_length_m + radius_m);

  const int last = static_cast<int>(mesh.vertices.size()) - 1;
  const int rings = (last - 1) / segments;
  const auto at = [&](int ring, int i) { return 1 + ring * segments + i % segments; };
  for (int i = 0; i < segments; ++i) {
    mesh.triangles.push_back({0, at(0, i + 1), at(0, i)});
    for (int ring = 0; ring + 1 < rings; ++ring) {
      add_quad(mesh, at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i));
    }
    mesh.triangles.push_back({last, at(rings - 1, i), at(rings - 1, i + 1)});
  }
  return mesh;
}

}  // namespace musclebench
