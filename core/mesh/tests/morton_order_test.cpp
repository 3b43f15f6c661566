#include "core/mesh/morton_order.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <span>
#include <utility>

#include <gtest/gtest.h>

#include "core/base/random_numbers.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

double path_length_m(const std::vector<Vec3>& points, const std::vector<int>& order) {
  double sum = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    sum += (points[order[i]] - points[order[i - 1]]).norm();
  }
  return sum;
}

std::vector<int> numbers(int count) {
  std::vector<int> result(count);
  std::iota(result.begin(), result.end(), 0);
  return result;
}

/// Of a 16 x 16 x 16 grid, without order.
std::vector<Vec3> shuffled_grid() {
  std::vector<Vec3> positions;
  for (int i = 0; i < 4096; ++i) {
    positions.emplace_back(Vec3(i % 16, i / 16 % 16, i / 256) - Vec3(100, 0, 7));
  }
  RandomNumbers random(1);
  for (std::size_t i = positions.size() - 1; i > 0; --i) {
    std::swap(positions[i], positions[random.below(i + 1)]);
  }
  return positions;
}

TEST(MortonOrder, LeadsFromNeighbourToNeighbour) {
  const std::vector<Vec3> points = shuffled_grid();
  const std::vector<int> order = morton_order(points);
  std::vector<int> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, numbers(4096));
  EXPECT_LT(path_length_m(points, order), 2 * 4096);
  EXPECT_GT(path_length_m(points, numbers(4096)), 10 * 4096);
}

/// Of a point in the unit cube, bit by bit: 1024 cells along an axis.
unsigned interleaved(const Vec3& point) {
  unsigned code = 0;
  for (unsigned bit = 0; bit < 10; ++bit) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<unsigned>(std::min(1024 * point[axis], 1023.0));
      code |= (cell >> bit & 1U) << (3 * bit + axis);
    }
  }
  return code;
}

TEST(MortonOrder, IsThatOfInterleavedCellIndices) {
  std::vector<Vec3> points = {Vec3::Zero(), Vec3::Ones()};
  RandomNumbers random(3);
  for (int i = 0; i < 5000; ++i) points.emplace_back(random.share(), random.share(), random.share());
  const std::vector<int> order = morton_order(points);
  for (std::size_t i = 1; i < order.size(); ++i) {
    ASSERT_LE(interleaved(points[order[i - 1]]), interleaved(points[order[i]])) << i;
  }
}

TEST(MortonOrder, LeavesAShortPathAsItIs) {
  std::vector<Vec3> points;
  for (int i = 0; i < 1000; ++i) {
    points.emplace_back(std::cos(0.01 * i), std::sin(0.01 * i), 0.001 * i);
  }
  EXPECT_EQ(morton_order(points), numbers(1000));
}

TEST(MortonOrder, TakesAnyPoints) {
  std::vector<Vec3> points = shuffled_grid();
  points[0] = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  points[1] = Vec3::Constant(std::numeric_limits<double>::infinity());
  points[2] = Vec3::Constant(-1e300);
  for (const std::size_t count : {4096, 3, 2, 1, 0}) {
    std::vector<int> order = morton_order(std::span(points).first(count));
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, numbers(static_cast<int>(count)));
  }
}

/// Numbered at random; the last vertex is not used.
TriangleMesh shuffled_sphere() {
  TriangleMesh mesh = make_sphere(1, 4);
  RandomNumbers random(2);
  const auto shuffle = [&](auto& parts, const auto& swapped) {
    for (std::size_t i = parts.size() - 1; i > 0; --i) {
      const std::size_t other = random.below(i + 1);
      std::swap(parts[i], parts[other]);
      swapped(static_cast<int>(i), static_cast<int>(other));
    }
  };
  shuffle(mesh.triangles, [](int, int) {});
  shuffle(mesh.vertices, [&](int a, int b) {
    for (Triangle& triangle : mesh.triangles) {
      for (int& vertex : triangle) {
        vertex = vertex == a ? b : vertex == b ? a : vertex;
      }
    }
  });
  mesh.vertices.emplace_back(7, 8, 9);
  return mesh;
}

/// By its corners' positions, in their order.
std::multiset<std::array<double, 9>> faces(const TriangleMesh& mesh) {
  std::multiset<std::array<double, 9>> result;
  for (const Triangle& triangle : mesh.triangles) {
    std::array<double, 9> face{};
    for (std::size_t i = 0; i < 9; ++i) {
      face[i] = mesh.vertices[static_cast<std::size_t>(triangle[i / 3])][static_cast<Eigen::Index>(i % 3)];
    }
    result.insert(face);
  }
  return result;
}

TEST(MortonOrder, OfAMeshLeavesTheSurfaceAsItIs) {
  const TriangleMesh shuffled = shuffled_sphere();
  TriangleMesh mesh = shuffled;
  sort_in_morton_order(mesh);
  EXPECT_EQ(faces(mesh), faces(shuffled));
  EXPECT_EQ(mesh.vertices.size(), shuffled.vertices.size());
  EXPECT_EQ(mesh.vertices.back(), Vec3(7, 8, 9));
  TriangleMesh again = mesh;
  sort_in_morton_order(again);
  EXPECT_EQ(again.triangles, mesh.triangles);
  EXPECT_EQ(again.vertices, mesh.vertices);
}

TEST(MortonOrder, OfAMeshPutsNeighboursTogether) {
  TriangleMesh mesh = shuffled_sphere();
  const double shuffled_m = path_length_m(mesh.vertices, numbers(static_cast<int>(mesh.vertices.size())));
  sort_in_morton_order(mesh);
  EXPECT_LT(path_length_m(mesh.vertices, numbers(static_cast<int>(mesh.vertices.size()))), 0.15 * shuffled_m);
  double corner_path_length_m = 0;
  for (std::size_t i = 1; i < mesh.triangles.size(); ++i) {
    corner_path_length_m += (mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][0])] -
                             mesh.vertices[static_cast<std::size_t>(mesh.triangles[i - 1][0])])
                                .norm();
  }
  EXPECT_LT(corner_path_length_m, 0.2 * static_cast<double>(mesh.triangles.size()));
}

TEST(MortonOrder, OfAMeshTakesAnyMesh) {
  TriangleMesh nothing;
  sort_in_morton_order(nothing);
  EXPECT_TRUE(nothing.triangles.empty());
  TriangleMesh not_finite{{Vec3::Constant(std::numeric_limits<double>::quiet_NaN()), Vec3::Zero()},
                          {{0, 1, 0}, {1, 1, 1}}};
  sort_in_morton_order(not_finite);
  EXPECT_EQ(not_finite.triangles.size(), 2U);
}

}  // namespace
}  // namespace musclebench
