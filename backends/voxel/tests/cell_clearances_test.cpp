#include "backends/voxel/cell_clearances.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "backends/voxel/tests/scalar_voxels.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

constexpr double none_m = std::numeric_limits<double>::infinity();

/// From a point, in units of cells, to the box of one cell.
double to_cell_m(const Vec3& scaled, const Vec3& low, const Vec3& cell_size_m) {
  return (low - scaled).cwiseMax(scaled - low - Vec3::Ones()).cwiseMax(0.0).cwiseProduct(cell_size_m).norm();
}

TEST(CellClearances, AreNeverLongerThanTheDistanceAndLittleShorter) {
  std::mt19937 random(3);
  for (const GridIndex& cells : {GridIndex{{9, 14, 6}}, GridIndex{{1, 1, 30}}, GridIndex{{17, 5, 1}}}) {
    for (const Vec3& size_m : {Vec3(1, 1, 1), Vec3(0.001, 0.004, 0.0005), Vec3(1e-12, 1, 3)}) {
      std::vector<std::uint64_t> bits((cells.size() + 63) / 64, 0);
      std::vector<Vec3> set;
      for (int n = 0; n < 3; ++n) {
        const std::size_t cell = random() % cells.size();
        bits[cell / 64] |= std::uint64_t{1} << (cell % 64);
        const auto [i, j, k] = cells.coordinates(cell);
        set.emplace_back(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
      }
      const Vec3 extent(static_cast<double>(cells.count[0]), static_cast<double>(cells.count[1]),
                        static_cast<double>(cells.count[2]));
      const double diagonal_m = 8 * extent.cwiseProduct(size_m).norm();  // so that no distance is cut short
      const CellClearances clearances(cells, size_m, diagonal_m, bits);
      EXPECT_EQ(clearances.bytes(), cells.size());
      for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        const auto [i, j, k] = cells.coordinates(cell);
        const Vec3 middle(static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5, static_cast<double>(k) + 0.5);
        double distance_m = none_m;
        for (const Vec3& low : set) distance_m = std::min(distance_m, to_cell_m(middle, low, size_m));
        ASSERT_LE(clearances.distance_m(cell), distance_m);
        // Three times rounded down by a step, which is twice the code.
        const double unit_m = diagonal_m / 8 / (255.0 * 255);
        ASSERT_GE(clearances.distance_m(cell), distance_m - 7 * (std::sqrt(distance_m * unit_m) + unit_m));
        ASSERT_EQ(clearances.distance_m(cell) == 0 && distance_m > 4 * unit_m, false);
      }
    }
  }
}

TEST(CellClearances, EndAtAnEighthOfTheDiagonal) {
  const GridIndex cells{{80, 1, 1}};
  std::vector<std::uint64_t> bits = {1, 0};
  const CellClearances clearances(cells, Vec3::Ones(), 80, bits);
  EXPECT_NEAR(clearances.distance_m(5), 4.5, 0.3);
  EXPECT_DOUBLE_EQ(clearances.distance_m(79), 10);
  bits = {0, 0};
  EXPECT_DOUBLE_EQ(CellClearances(cells, Vec3::Ones(), 80, bits).distance_m(0), 10) << "no set cell";
}

/// A grid whose clearances are looked at, its set cells, and those that it leaves out, all as their lower corners.
struct Grid {
  VoxelGrid grid;
  std::vector<Vec3> set, left_out;

  explicit Grid(VoxelGrid made) : grid(std::move(made)) {
    grid.find_clearances();
    const Vec3 counts = grid.view().counts;
    for (int z = 0; z < counts.z(); ++z) {
      for (int y = 0; y < counts.y(); ++y) {
        for (int x = 0; x < counts.x(); ++x) {
          const Vec3 low(x, y, z);
          const Vec3 middle = low + Vec3::Constant(0.5);
          if (contains_scaled(grid, middle)) set.push_back(low);
          if (leaves_out_scaled(grid, middle)) left_out.push_back(low);
        }
      }
    }
  }
};

/// By itself; and as one of several nodes.
double clearance_m(const VoxelGrid& grid, const Vec3& scaled) {
  VoxelBlock block;
  const auto place = [&](std::size_t n, const Vec3& cells) {
    block.x[n] = cells.x();
    block.y[n] = cells.y();
    block.z[n] = cells.z();
  };
  for (std::size_t n = 0; n < 8; ++n) place(n, scaled + static_cast<double>(n) * Vec3::Ones());
  place(5, scaled);
  find_clearances(grid, 6, block);
  EXPECT_TRUE(block.clearance_m[0] == block.clearance_m[5] || !scaled.allFinite());
  return block.clearance_m[5];
}

double least_m(const Vec3& scaled, const std::vector<Vec3>& cells, const Vec3& cell_size_m) {
  double least_m = none_m;
  for (const Vec3& low : cells) least_m = std::min(least_m, to_cell_m(scaled, low, cell_size_m));
  return least_m;
}

/// How far a point is free, by all cells; and that no clearance is longer, nor shorter than the way to the middle of
/// a cell costs.
void expect_good_clearances(const Grid& tested) {
  const VoxelGrid& grid = tested.grid;
  std::mt19937 random(9);
  std::uniform_real_distribution<double> share(-0.3, 1.3);
  const double cell_m = grid.cell_size_m().norm();
  int free = 0, useful = 0;
  for (int n = 0; n < 3000; ++n) {
    const Vec3 scaled = Vec3(share(random), share(random), share(random)).cwiseProduct(grid.view().counts);
    if (contains_scaled(grid, scaled) || leaves_out_scaled(grid, scaled)) continue;
    const double to_set_m = least_m(scaled, tested.set, grid.cell_size_m());
    const double to_left_out_m = least_m(scaled, tested.left_out, grid.cell_size_m());
    const double found_m = clearance_m(grid, scaled);
    ASSERT_LE(found_m, std::min(to_set_m, to_left_out_m)) << scaled.transpose();
    const double reach_m = grid.view().counts.cwiseProduct(grid.cell_size_m()).norm() / 8;
    if (is_kept(grid, scaled)) {
      ASSERT_GE(found_m, std::min({0.9 * to_set_m, to_left_out_m, 0.99 * reach_m}) - cell_m);
    }
    ++free;
    useful += found_m > 0.25 * std::min(to_set_m, to_left_out_m) ? 1 : 0;
  }
  EXPECT_GT(free, 1000);
  EXPECT_GT(useful, 800);
}

TEST(VoxelClearances, NoSetCellAndNoneThatIsLeftOutIsNearer) {
  const TriangleMesh bone = make_capsule(0.01, 0.04, 16);
  const TriangleBvh tree(bone);
  expect_good_clearances(Grid({bone, tree, true, 13, 0, "test"}));
  expect_good_clearances(Grid({bone, tree, true, 13, 0.0021, "test"}));
  const Eigen::AlignedBox3d end(Vec3(-0.003, -1, 0.02), Vec3(1, 1, 0.045));
  expect_good_clearances(Grid({bone, tree, true, 13, 0, "test", end}));
  // All that is set lies beyond the part.
  const Eigen::AlignedBox3d corner(Vec3(0.0085, 0.0085, -1), Vec3(1, 1, 1));
  const Grid free({bone, tree, true, 13, 0, "test", corner});
  EXPECT_TRUE(free.set.empty());
  expect_good_clearances(free);
}

TEST(VoxelClearances, WhatIsNoNumberHasNone) {
  VoxelGrid grid(make_sphere(1, 2), 8, 0, "test");
  grid.find_clearances();
  EXPECT_FALSE(clearance_m(grid, Vec3(std::numeric_limits<double>::quiet_NaN(), 1, 1)) > 0);
}

}  // namespace
}  // namespace musclebench
