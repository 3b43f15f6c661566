#include "backends/voxel/voxel_grid.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "backends/voxel/tests/scalar_voxels.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

TEST(VoxelGrid, EveryPointInsideIsFlaggedAndFalseOnesAreWithinACell) {
  const double radius = 0.04;
  const TriangleMesh sphere = make_sphere(radius, 4);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-1.2 * radius, 1.2 * radius);
  for (const int cells : {1, 2, 7, 32, 64}) {
    const VoxelGrid grid(sphere, cells, 0, "test");
    int false_ones = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 x(coordinate(random), coordinate(random), coordinate(random));
      const double d = x.norm() - radius;
      if (d < -1e-4 * radius - 2e-4 * radius) {
        ASSERT_TRUE(contains(grid, x)) << cells << " " << d;
      }
      if (d > 0 && contains(grid, x)) {
        ++false_ones;
        ASSERT_LE(d, grid.cell_size_m().norm());
      }
    }
    EXPECT_GT(false_ones, 0) << cells;
  }
}

TEST(VoxelGrid, CellsFollowTheBoxOrAreCubes) {
  const TriangleMesh box = make_box(Vec3(0.01, 0.02, 0.04), 2);
  const VoxelGrid counted(box, 10, 0, "test");
  EXPECT_EQ(counted.counts(), (std::array<int, 3>{10, 10, 10}));
  EXPECT_NEAR(counted.cell_size_m().z() / counted.cell_size_m().x(), 4, 1e-6);
  const VoxelGrid cubes(box, 10, 0.003, "test");
  EXPECT_EQ(cubes.cell_size_m(), Vec3::Constant(0.003));
  EXPECT_EQ(cubes.counts(), (std::array<int, 3>{7, 14, 27}));
}

TEST(VoxelGrid, APartHoldsWhatTheWholeHoldsThere) {
  const TriangleMesh bone = make_capsule(0.01, 0.04, 16);
  const TriangleBvh tree(bone);
  for (const double voxel_size_m : {0.0, 0.0017}) {
    const VoxelGrid whole(bone, 19, voxel_size_m, "test");
    EXPECT_EQ(whole.kept_share(), 1);
    for (const Eigen::AlignedBox3d& box : {Eigen::AlignedBox3d(Vec3(-0.004, -1, 0.01), Vec3(0.002, 1, 0.02)),
                                           Eigen::AlignedBox3d(Vec3(1, 1, 1), Vec3(2, 2, 2))}) {
      const VoxelGrid part(bone, tree, true, 19, voxel_size_m, "test", box);
      EXPECT_GT(part.kept_share(), 0);
      EXPECT_LT(part.kept_share(), 0.3);
      EXPECT_LT(part.bytes(), whole.bytes());
      int left_out = 0;
      for (int n = 0; n < 20000; ++n) {
        const Vec3 scaled =
            1.2 * Vec3(n % 29, n / 29 % 27, n / 29 / 27).cwiseProduct(Vec3(0.9, 1.1, 1.7)) - Vec3::Ones();
        const Vec3 point = whole.lower() + scaled.cwiseProduct(whole.cell_size_m());
        left_out += leaves_out_scaled(part, scaled) ? 1 : 0;
        EXPECT_FALSE(leaves_out_scaled(part, scaled) && box.contains(point)) << point.transpose();
        EXPECT_EQ(contains_scaled(part, scaled), contains_scaled(whole, scaled) && !leaves_out_scaled(part, scaled));
      }
      EXPECT_GT(left_out, 1000);
    }
  }
}

/// A flood fill from the first cell would run out of the hole and take the whole ball for empty.
TEST(VoxelGrid, AHoleLosesNothingOfTheInside) {
  TriangleMesh open = make_sphere(1, 4);
  std::erase_if(open.triangles, [&](const Triangle& triangle) {
    return open.vertices[static_cast<std::size_t>(triangle[0])].x() > 0.985;
  });
  const TriangleBvh tree(open);
  ASSERT_LT(open.triangles.size(), 5120U);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-1.2, 1.2);
  for (const int cells : {8, 33, 64}) {
    const VoxelGrid grid(open, tree, false, cells, 0, "test");
    int inside = 0;
    for (int i = 0; i < 5000; ++i) {
      const Vec3 x(coordinate(random), coordinate(random), coordinate(random));
      if (tree.winding_number(x) > 0.5) {
        ++inside;
        ASSERT_TRUE(contains(grid, x)) << cells << ": " << x.transpose();
      } else if (x.norm() > 1) {
        ASSERT_TRUE(!contains(grid, x) || x.norm() - 1 <= 2 * grid.cell_size_m().norm()) << x.transpose();
      }
    }
    EXPECT_GT(inside, 1000);
  }
}

TEST(VoxelGrid, OneBitACell) { EXPECT_EQ(VoxelGrid(make_sphere(1, 2), 64, 0, "test").bytes(), 32768U); }

TEST(VoxelGrid, AnEnclosedPocketOfFreeSpaceIsFree) {
  // A hollow ball: the cavity is cut off from the outside, yet it is not inside the bone.
  TriangleMesh shell = make_sphere(0.04, 4);
  const TriangleMesh cavity = make_sphere(0.03, 4);
  const int offset = static_cast<int>(shell.vertices.size());
  shell.vertices.insert(shell.vertices.end(), cavity.vertices.begin(), cavity.vertices.end());
  for (const Triangle& t : cavity.triangles) {
    shell.triangles.push_back({t[0] + offset, t[2] + offset, t[1] + offset});
  }
  const VoxelGrid grid(shell, 64, 0, "test");
  EXPECT_FALSE(contains(grid, Vec3(0, 0, 0)));
  EXPECT_TRUE(contains(grid, Vec3(0.035, 0, 0)));
  EXPECT_FALSE(contains(grid, Vec3(0.05, 0, 0)));
}

TEST(VoxelGrid, FarFromTheOriginTheSurfaceStaysIn) {
  TriangleMesh box = make_box(Vec3(0.01, 0.02, 0.04), 2);
  for (Vec3& x : box.vertices) {
    x += Vec3(1e3, -1e3, 1e3);
  }
  const VoxelGrid grid(box, 16, 0, "test");
  for (const Vec3& x : box.vertices) {
    EXPECT_TRUE(contains(grid, x));
  }
}

TEST(VoxelGrid, TooManyCellsAreRefusedWithTheirSize) {
  try {
    const VoxelGrid grid(make_sphere(1, 2), 100000, 0, "voxel: cells (bone 'femur')");
    FAIL();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("femur"), std::string::npos);
    EXPECT_NE(message.find("MB"), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace musclebench
