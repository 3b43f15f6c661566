#include "core/distance/pseudo_normals.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>

#include <Eigen/Geometry>

#include "core/base/arc_tangent.hpp"

namespace musclebench {

namespace {

struct EdgeUse {
  std::pair<int, int> ends;
  int edge = 0;  ///< 3 * triangle + edge of the triangle
};

/// The triangle across every triangle edge; -1 at edges of one triangle or of more than two.
std::vector<int> neighbours(const std::vector<Triangle>& triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      uses.push_back({std::minmax(triangles[t][i], triangles[t][(i + 1) % 3]), static_cast<int>(3 * t + i)});
    }
  }
  std::sort(uses.begin(), uses.end(),
            [](const EdgeUse& a, const EdgeUse& b) { return a.ends != b.ends ? a.ends < b.ends : a.edge < b.edge; });
  std::vector<int> result(uses.size(), -1);
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    while (end < uses.size() && uses[end].ends == uses[begin].ends) {
      ++end;
    }
    if (end - begin == 2) {
      result[static_cast<std::size_t>(uses[begin].edge)] = uses[begin + 1].edge / 3;
      result[static_cast<std::size_t>(uses[begin + 1].edge)] = uses[begin].edge / 3;
    }
  }
  return result;
}

/// Unit; zero for a triangle without area.
Vec3 face_normal(std::span<const Vec3> vertices, const Triangle& triangle) {
  const auto corner = [&](std::size_t i) { return vertices[static_cast<std::size_t>(triangle[i])]; };
  const Vec3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
  const double length = normal.norm();
  return length > 0 ? Vec3(normal / length) : Vec3(Vec3::Zero());
}

/// Of a corner of a triangle, rad.
double corner_angle(std::span<const Vec3> vertices, const Triangle& triangle, std::size_t i) {
  const auto corner = [&](std::size_t k) { return vertices[static_cast<std::size_t>(triangle[k % 3])]; };
  const Vec3 to_next = corner(i + 1) - corner(i);
  const Vec3 to_last = corner(i + 2) - corner(i);
  // The arc tangent is accurate for obtuse and tiny angles; acos and asin are not. States depend on it.
  return arc_tangent2(to_next.cross(to_last).norm(), to_next.dot(to_last));
}

}  // namespace

PseudoNormals::PseudoNormals(const TriangleMesh& mesh)
    : m_triangles(mesh.triangles),
      m_of_vertex(mesh.vertices.size(), Vec3::Zero()),
      m_neighbour(neighbours(mesh.triangles)) {
  m_of_face.reserve(m_triangles.size());
  for (const Triangle& triangle : m_triangles) {
    m_of_face.push_back(face_normal(mesh.vertices, triangle));
    for (std::size_t i = 0; i < 3; ++i) {
      m_of_vertex[static_cast<std::size_t>(triangle[i])] += corner_angle(mesh.vertices, triangle, i) * m_of_face.back();
    }
  }
}

Vec3 PseudoNormals::at(int triangle, Feature feature) const {
  const auto t = static_cast<std::size_t>(triangle);
  if (feature == Feature::face) {
    return m_of_face[t];
  }
  if (feature < Feature::corner_0) {
    const auto edge = static_cast<std::size_t>(feature) - static_cast<std::size_t>(Feature::edge_0);
    const int other = m_neighbour[3 * t + edge];
    return other < 0 ? m_of_face[t] : Vec3(m_of_face[t] + m_of_face[static_cast<std::size_t>(other)]);
  }
  const auto corner = static_cast<std::size_t>(feature) - static_cast<std::size_t>(Feature::corner_0);
  return m_of_vertex[static_cast<std::size_t>(m_triangles[t][corner])];
}

MovingPseudoNormals::MovingPseudoNormals(const TriangleMesh& mesh)
    : m_triangles(mesh.triangles),
      m_neighbour(neighbours(mesh.triangles)),
      m_first_side(mesh.vertices.size() + 1, 0),
      m_sides(3 * mesh.triangles.size()) {
  for (const Triangle& triangle : m_triangles) {
    for (const int vertex : triangle) ++m_first_side[static_cast<std::size_t>(vertex) + 1];
  }
  std::partial_sum(m_first_side.begin(), m_first_side.end(), m_first_side.begin());
  std::vector<int> next(m_first_side.begin(), m_first_side.end() - 1);
  for (std::size_t side = 0; side < m_sides.size(); ++side) {
    const int vertex = m_triangles[side / 3][side % 3];
    m_sides[static_cast<std::size_t>(next[static_cast<std::size_t>(vertex)]++)] = static_cast<int>(side);
  }
}

Vec3 MovingPseudoNormals::at(std::span<const Vec3> vertices, int triangle, Feature feature) const {
  const auto normal_of = [&](int t) { return face_normal(vertices, m_triangles[static_cast<std::size_t>(t)]); };
  if (feature == Feature::face) {
    return normal_of(triangle);
  }
  const auto t = static_cast<std::size_t>(triangle);
  if (feature < Feature::corner_0) {
    const auto edge = static_cast<std::size_t>(feature) - static_cast<std::size_t>(Feature::edge_0);
    const int other = m_neighbour[3 * t + edge];
    return other < 0 ? normal_of(triangle) : Vec3(normal_of(triangle) + normal_of(other));
  }
  const auto corner = static_cast<std::size_t>(feature) - static_cast<std::size_t>(Feature::corner_0);
  const auto vertex = static_cast<std::size_t>(m_triangles[t][corner]);
  Vec3 sum = Vec3::Zero();
  for (int i = m_first_side[vertex]; i < m_first_side[vertex + 1]; ++i) {
    const int side = m_sides[static_cast<std::size_t>(i)];
    const Triangle& about = m_triangles[static_cast<std::size_t>(side / 3)];
    sum += corner_angle(vertices, about, static_cast<std::size_t>(side % 3)) * face_normal(vertices, about);
  }
  return sum;
}

}  // namespace musclebench
