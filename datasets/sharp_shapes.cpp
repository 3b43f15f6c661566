#include "datasets/sharp_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "core/base/portable_math.hpp"
#include "core/mesh/split_mesh.hpp"

namespace musclebench {

namespace {

/// What was made for `up` = 1, turned by half a turn about y where it is to hang.
TriangleMesh upright(TriangleMesh mesh, double up) {
  for (Vec3& vertex : mesh.vertices) vertex = Vec3(up * vertex.x(), vertex.y(), up * vertex.z());
  return mesh;
}

/// An outline in the plane of x and z, counter-clockwise as seen against y, drawn out along y.
TriangleMesh drawn_out(const std::vector<std::array<double, 2>>& outline, const std::vector<Triangle>& cap,
                       double half_length_m) {
  const int corners = static_cast<int>(outline.size());
  TriangleMesh mesh;
  for (const double y_m : {-half_length_m, half_length_m}) {
    for (const auto& [x_m, z_m] : outline) mesh.vertices.emplace_back(x_m, y_m, z_m);
  }
  for (const auto& [a, b, c] : cap) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a + corners, c + corners, b + corners});
  }
  for (int here = 0; here < corners; ++here) {
    const int next = (here + 1) % corners;
    mesh.triangles.push_back({here, here + corners, next});
    mesh.triangles.push_back({next, here + corners, next + corners});
  }
  return mesh;
}

}  // namespace

TriangleMesh make_cone(double radius_m, double height_m, int sides, double up) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3::Zero(), {0, 0, -height_m}};
  for (int i = 0; i < sides; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / sides;
    mesh.vertices.emplace_back(radius_m * portable::cos(angle_rad), radius_m * portable::sin(angle_rad), -height_m);
  }
  for (int i = 0; i < sides; ++i) {
    const int here = 2 + i;
    const int next = 2 + (i + 1) % sides;
    mesh.triangles.push_back({here, next, 0});
    mesh.triangles.push_back({next, here, 1});
  }
  return upright(std::move(mesh), up);
}

TriangleMesh make_wedge(double half_width_m, double height_m, double half_length_m, double up) {
  return upright(drawn_out({{-half_width_m, -height_m}, {half_width_m, -height_m}, {0, 0}}, {{0, 1, 2}}, half_length_m),
                 up);
}

TriangleMesh make_cracked_block(double half_width_m, double depth_m) {
  constexpr double half_m = 0.05;
  return drawn_out({{-half_m, -half_m},
                    {half_m, -half_m},
                    {half_m, 0},
                    {half_width_m, 0},
                    {0, -depth_m},
                    {-half_width_m, 0},
                    {-half_m, 0}},
                   {{0, 1, 4}, {1, 3, 4}, {1, 2, 3}, {0, 4, 5}, {0, 5, 6}}, half_m);
}

TriangleMesh make_skids(double half_length_m) {
  return split_flat(drawn_out({{-0.012, 0}, {0, 0.012}, {0.012, 0}, {0.02, 0.02}, {-0.02, 0.02}},
                              {{0, 1, 4}, {1, 3, 4}, {1, 2, 3}}, half_length_m),
                    2);
}

TriangleMesh make_channel(double half_length_m) {
  return split_flat(drawn_out({{-0.015, 0},
                               {0.015, 0},
                               {0.015, 0.03},
                               {0.007, 0.03},
                               {0.007, 0.008},
                               {-0.007, 0.008},
                               {-0.007, 0.03},
                               {-0.015, 0.03}},
                              {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}}, half_length_m),
                    2);
}

TriangleMesh make_holed_plate() {
  constexpr int cells = 7;
  constexpr double cell_m = 0.012;
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> corners;
  const auto corner = [&](const std::array<int, 3>& at) {
    const auto [found, is_new] = corners.try_emplace(at, static_cast<int>(mesh.vertices.size()));
    if (is_new)
      mesh.vertices.emplace_back((at[0] - 0.5 * cells) * cell_m, (at[1] - 0.5 * cells) * cell_m, at[2] * cell_m);
    return found->second;
  };
  const auto is_filled = [](int x, int y) {
    return x >= 0 && y >= 0 && x < cells && y < cells && !(x == cells / 2 && y == cells / 2);
  };
  const auto add_square = [&](const std::array<std::array<int, 3>, 4>& around) {
    const int a = corner(around[0]), b = corner(around[1]), c = corner(around[2]), d = corner(around[3]);
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (int x = 0; x < cells; ++x) {
    for (int y = 0; y < cells; ++y) {
      if (!is_filled(x, y)) continue;
      add_square({{{x, y, 0}, {x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0}}});
      add_square({{{x, y, -1}, {x, y + 1, -1}, {x + 1, y + 1, -1}, {x + 1, y, -1}}});
      if (!is_filled(x - 1, y)) add_square({{{x, y, -1}, {x, y, 0}, {x, y + 1, 0}, {x, y + 1, -1}}});
      if (!is_filled(x + 1, y)) add_square({{{x + 1, y, -1}, {x + 1, y + 1, -1}, {x + 1, y + 1, 0}, {x + 1, y, 0}}});
      if (!is_filled(x, y - 1)) add_square({{{x, y, -1}, {x + 1, y, -1}, {x + 1, y, 0}, {x, y, 0}}});
      if (!is_filled(x, y + 1)) add_square({{{x, y + 1, -1}, {x, y + 1, 0}, {x + 1, y + 1, 0}, {x + 1, y + 1, -1}}});
    }
  }
  return mesh;
}

}  // namespace musclebench
