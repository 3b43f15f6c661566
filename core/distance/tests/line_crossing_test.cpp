// A line through a closed surface counts each sheet once, also where it meets a corner or an edge.
#include "core/distance/line_crossing.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// Of all triangles on one side of the plane x = 0, along the x axis.
int turns(const TriangleMesh& mesh, bool in_front) {
  int sum = 0;
  for (const Triangle& triangle : mesh.triangles) {
    std::array<Vec3, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = mesh.vertices[static_cast<std::size_t>(triangle[i])];
    const bool is_in_front = (corners[0] + corners[1] + corners[2]).x() > 0;
    if (is_in_front == in_front) sum += turns_about_line(corners);
  }
  return sum;
}

TriangleMesh octahedron() {
  return {{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitX(), -Vec3::UnitY(), -Vec3::UnitZ()},
          {{0, 1, 2}, {0, 2, 4}, {0, 4, 5}, {0, 5, 1}, {3, 2, 1}, {3, 4, 2}, {3, 5, 4}, {3, 1, 5}}};
}

/// The line runs through two corners, and four corners beside them are level with it or above and below it.
TEST(LineCrossing, ThroughCornersCountsASheetOnce) {
  TriangleMesh mesh = octahedron();
  EXPECT_EQ(turns(mesh, true), 1);
  EXPECT_EQ(turns(mesh, false), -1);
  for (auto& [a, b, c] : mesh.triangles) std::swap(b, c);
  EXPECT_EQ(turns(mesh, true), -1);
  EXPECT_EQ(turns(mesh, false), 1);
}

/// Any turn about the line: corners pass its level from above and from below.
TEST(LineCrossing, HasNoPreferredDirectionAboutTheLine) {
  for (int degrees = 0; degrees < 360; degrees += 15) {
    const double angle_rad = degrees * std::numbers::pi / 180;
    TriangleMesh mesh = octahedron();
    for (Vec3& vertex : mesh.vertices) {
      vertex = Vec3(vertex.x(), std::cos(angle_rad) * vertex.y() - std::sin(angle_rad) * vertex.z(),
                    std::sin(angle_rad) * vertex.y() + std::cos(angle_rad) * vertex.z());
    }
    EXPECT_EQ(turns(mesh, true), 1) << degrees;
    EXPECT_EQ(turns(mesh, false), -1) << degrees;
  }
}

/// A box cut into triangles, and lines through its edges, diagonals and corners; those along its border may miss it,
/// but then on both sides.
TEST(LineCrossing, EntersAsOftenAsItLeaves) {
  const TriangleMesh box = make_box(Vec3(1, 1, 1), 4);
  for (int i = -10; i <= 10; ++i) {
    for (int k = -10; k <= 10; ++k) {
      TriangleMesh moved = box;
      for (Vec3& vertex : moved.vertices) vertex += Vec3(0, 0.125 * i, 0.125 * k);
      const int front = turns(moved, true);
      EXPECT_EQ(front + turns(moved, false), 0) << i << ", " << k;
      if (std::abs(i) < 8 && std::abs(k) < 8) {
        EXPECT_EQ(front, 1) << i << ", " << k;
      }
      if (std::abs(i) > 8 || std::abs(k) > 8) {
        EXPECT_EQ(front, 0) << i << ", " << k;
      }
    }
  }
}

}  // namespace
}  // namespace musclebench
