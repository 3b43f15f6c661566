#include "datasets/hard/hard_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "core/mesh/shapes.hpp"

namespace musclebench {

namespace {

using Edge = std::pair<int, int>;

/// Of each directed edge, a triangle that has it.
std::map<Edge, int> triangles_by_edge(const TriangleMesh& mesh) {
  std::map<Edge, int> found;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      found[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}] = static_cast<int>(t);
    }
  }
  return found;
}

Vec3 centroid(const TriangleMesh& mesh, const Triangle& triangle) {
  Vec3 sum = Vec3::Zero();
  for (const int vertex : triangle) sum += mesh.vertices[static_cast<std::size_t>(vertex)];
  return sum / 3;
}

/// Splits the edge of `triangle` from its first to its second corner at `share` of it, in both triangles that have it.
void split_edge(TriangleMesh& mesh, int triangle, int neighbour, double share) {
  const auto [a, b, c] = mesh.triangles[static_cast<std::size_t>(triangle)];
  const Vec3& start = mesh.vertices[static_cast<std::size_t>(a)];
  const Vec3& end = mesh.vertices[static_cast<std::size_t>(b)];
  const int middle = static_cast<int>(mesh.vertices.size());
  mesh.vertices.push_back(start + share * (end - start));
  Triangle other = mesh.triangles[static_cast<std::size_t>(neighbour)];
  while (other[0] != b) std::rotate(other.begin(), other.begin() + 1, other.end());
  mesh.triangles[static_cast<std::size_t>(triangle)] = {a, middle, c};
  mesh.triangles[static_cast<std::size_t>(neighbour)] = {b, middle, other[2]};
  mesh.triangles.push_back({middle, b, c});
  mesh.triangles.push_back({middle, a, other[2]});
}

}  // namespace

TriangleMesh make_spike() {
  constexpr int sides = 24;
  constexpr double radius_m = 0.003;
  constexpr double half_height_m = 0.03;
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, half_height_m}, {0, 0, -half_height_m}};
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / sides;
    mesh.vertices.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), -half_height_m);
  }
  for (int i = 0; i < sides; ++i) {
    const int here = 2 + i;
    const int next = 2 + (i + 1) % sides;
    mesh.triangles.push_back({here, next, 0});
    mesh.triangles.push_back({next, here, 1});
  }
  return mesh;
}

TriangleMesh make_bumpy_ball(int subdivisions) {
  TriangleMesh mesh = make_sphere(0.025, subdivisions);
  for (Vec3& vertex : mesh.vertices) {
    const Vec3 direction = vertex.normalized();
    vertex *= 1 + 0.4 * std::sin(6 * direction.x()) * std::sin(5 * direction.y() + 1) * std::cos(4 * direction.z());
  }
  return mesh;
}

TriangleMesh make_plate(double thickness_m) { return make_box({0.05, 0.05, 0.5 * thickness_m}, 8); }

TriangleMesh make_shrinking_row(int parts, double factor) {
  TriangleMesh mesh;
  double place_m = 0.1;
  for (int part = 0; part < parts; ++part, place_m *= factor) {
    const double size_m = 0.004 * place_m;
    const Vec3 first(place_m, 0, 0);
    const int v = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {first, first + size_m * Vec3::UnitX(), first + size_m * Vec3::UnitY(),
                                               first + size_m * Vec3::UnitZ()});
    mesh.triangles.insert(mesh.triangles.end(),
                          {{v, v + 2, v + 1}, {v, v + 1, v + 3}, {v, v + 3, v + 2}, {v + 1, v + 2, v + 3}});
  }
  return mesh;
}

TriangleMesh make_winged_block(double thickness_m) {
  constexpr double half_m = 0.05;
  constexpr double wing_x_m = 0.0123;
  const double left_m = wing_x_m - 0.5 * thickness_m;
  const double right_m = wing_x_m + 0.5 * thickness_m;
  // The outline in the plane of x and z, counter-clockwise, and the triangles of its inside.
  const std::array<std::array<double, 2>, 8> outline{{{-half_m, 0},
                                                      {half_m, 0},
                                                      {half_m, 0.02},
                                                      {right_m, 0.02},
                                                      {right_m, 0.1},
                                                      {left_m, 0.1},
                                                      {left_m, 0.02},
                                                      {-half_m, 0.02}}};
  constexpr std::array<Triangle, 6> cap{{{0, 1, 2}, {0, 2, 3}, {0, 3, 6}, {0, 6, 7}, {3, 4, 5}, {3, 5, 6}}};
  constexpr int corners = 8;
  TriangleMesh mesh;
  for (const double y_m : {-half_m, half_m}) {
    for (const auto& [x_m, z_m] : outline) mesh.vertices.emplace_back(x_m, y_m, z_m);
  }
  for (const auto& [a, b, c] : cap) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a + corners, c + corners, b + corners});
  }
  for (int i = 0; i < corners; ++i) {
    const int next = (i + 1) % corners;
    mesh.triangles.push_back({i, i + corners, next + corners});
    mesh.triangles.push_back({i, next + corners, next});
  }
  return mesh;
}

TriangleMesh with_hole(const TriangleMesh& mesh, int triangles, const Vec3& direction) {
  const std::map<Edge, int> by_edge = triangles_by_edge(mesh);
  const auto farthest =
      std::max_element(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& one, const Triangle& other) {
        return direction.dot(centroid(mesh, one)) < direction.dot(centroid(mesh, other));
      });
  std::vector<char> is_hole(mesh.triangles.size(), 0);
  std::deque<int> front = {static_cast<int>(farthest - mesh.triangles.begin())};
  int left = triangles;
  while (left > 0 && !front.empty()) {
    const auto t = static_cast<std::size_t>(front.front());
    front.pop_front();
    if (is_hole[t] != 0) continue;
    is_hole[t] = 1;
    --left;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto neighbour = by_edge.find({mesh.triangles[t][(k + 1) % 3], mesh.triangles[t][k]});
      if (neighbour != by_edge.end()) front.push_back(neighbour->second);
    }
  }
  TriangleMesh result{mesh.vertices, {}};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (is_hole[t] == 0) result.triangles.push_back(mesh.triangles[t]);
  }
  return result;
}

TriangleMesh with_bad_triangles(const TriangleMesh& mesh) {
  constexpr std::size_t stride = 29;
  constexpr double sliver_share = 1e-8;
  TriangleMesh bad = mesh;
  std::vector<char> is_split(mesh.triangles.size(), 0);
  const std::map<Edge, int> by_edge = triangles_by_edge(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += stride) {
    const Triangle triangle = mesh.triangles[t];
    const auto neighbour = static_cast<std::size_t>(by_edge.at({triangle[1], triangle[0]}));
    if (is_split[t] != 0 || is_split[neighbour] != 0) continue;
    is_split[t] = is_split[neighbour] = 1;
    split_edge(bad, static_cast<int>(t), static_cast<int>(neighbour), sliver_share);
    // Without area, at a copy of a corner; and one triangle twice.
    bad.vertices.push_back(mesh.vertices[static_cast<std::size_t>(triangle[0])]);
    bad.triangles.push_back({triangle[0], static_cast<int>(bad.vertices.size()) - 1, triangle[2]});
    bad.triangles.push_back(bad.triangles[t]);
  }
  return bad;
}

TriangleMesh inside_out(TriangleMesh mesh) {
  for (Triangle& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  return mesh;
}

TriangleMesh scaled(TriangleMesh mesh, double factor) {
  for (Vec3& vertex : mesh.vertices) vertex *= factor;
  return mesh;
}

TriangleMesh shifted(TriangleMesh mesh, const Vec3& by_m) {
  for (Vec3& vertex : mesh.vertices) vertex += by_m;
  return mesh;
}

}  // namespace musclebench
