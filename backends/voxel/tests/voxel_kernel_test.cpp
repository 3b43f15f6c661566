#include "backends/voxel/voxel_kernel.hpp"

#include <limits>
#include <numeric>
#include <random>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "backends/voxel/tests/scalar_voxels.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

class VoxelKernel : public testing::Test {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  /// With every kind of SIMD that this CPU has.
  template <typename Check>
  static void on_each_target(const Check& check) {
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      SCOPED_TRACE(hwy::TargetName(target));
      hwy::SetSupportedTargetsForTest(target);
      check();
    }
  }
};

/// About a bone: in its box and around it, on the very borders of cells, far away, and no numbers at all.
std::vector<Vec3> positions_about(const VoxelGrid& grid, const RigidMotion& pose, std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-0.15, 1.15);
  std::vector<Vec3> positions;
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 cells = Vec3(share(random), share(random), share(random)).cwiseProduct(grid.view().counts);
    if (i % 5 == 0) cells = cells.array().round();
    positions.push_back(pose.apply(grid.point(cells)));
    if (i % 31 == 0) positions.back() *= 1e12;
    if (i % 37 == 0) positions.back()[static_cast<Eigen::Index>(i % 3)] = std::numeric_limits<double>::quiet_NaN();
    if (i % 41 == 0) positions.back()[static_cast<Eigen::Index>(i % 3)] = std::numeric_limits<double>::infinity();
  }
  return positions;
}

std::vector<VoxelGrid> grids() {
  const TriangleMesh bone = make_capsule(0.01, 0.04, 16);
  const TriangleBvh tree(bone);
  std::vector<VoxelGrid> grids;
  grids.emplace_back(bone, tree, true, 19, 0.0, "test");
  grids.emplace_back(bone, tree, true, 19, 0.0013, "test");
  grids.emplace_back(bone, tree, true, 19, 0.0, "test",
                     Eigen::AlignedBox3d(Vec3(-0.004, -1, 0.01), Vec3(0.006, 1, 0.02)));
  return grids;
}

/// Bit by bit and coordinate by coordinate; returns how many nodes are in a set cell.
int expect_as_scalar(const VoxelGrid& grid, const RigidMotion& pose, const std::vector<Vec3>& positions,
                     std::span<const int> nodes) {
  const VoxelMap map(grid, pose);
  VoxelBlock block;
  block.in_set = block.left_out = ~std::uint64_t{0};  // of the block before
  look_up(grid, map, positions, nodes, block);
  int in_set = 0;
  for (std::size_t n = 0; n < 64; ++n) {
    const bool is_in_set = ((block.in_set >> n) & 1U) != 0;
    const bool is_left_out = ((block.left_out >> n) & 1U) != 0;
    if (n >= nodes.size()) {
      EXPECT_FALSE(is_in_set || is_left_out) << n;
      continue;
    }
    const Vec3 cells = to_cells(map, positions[static_cast<std::size_t>(nodes[n])]);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double found = block.cells(n)[axis];
      EXPECT_TRUE(found == cells[axis] || (std::isnan(found) && std::isnan(cells[axis]))) << n;
    }
    EXPECT_EQ(is_in_set, contains_scaled(grid, cells)) << n;
    EXPECT_EQ(is_left_out, leaves_out_scaled(grid, cells)) << n;
    in_set += is_in_set ? 1 : 0;
  }
  return in_set;
}

TEST_F(VoxelKernel, LanesGiveTheBitsOfTheScalarFormOnEveryCpu) {
  const RigidMotion pose = RigidMotion::about_axis(Vec3(1, 2, -0.5).normalized(), Vec3(0.1, -0.2, 0.05), 0.9);
  for (const VoxelGrid& grid : grids()) {
    const std::vector<Vec3> positions = positions_about(grid, pose, 6400);
    std::vector<int> all(positions.size());
    std::iota(all.begin(), all.end(), 0);
    std::vector<int> some;  // not side by side
    for (const int node : all) {
      if (node % 3 != 1) some.push_back(node);
    }
    on_each_target([&] {
      int in_set = 0;
      for (std::size_t first = 0; first + 64 <= some.size(); first += 64) {
        in_set += expect_as_scalar(grid, pose, positions, std::span(all).subspan(first, 64));
        in_set += expect_as_scalar(grid, pose, positions, std::span(some).subspan(first, 64));
      }
      EXPECT_GT(in_set, 200);
    });
  }
}

TEST_F(VoxelKernel, ABlockMayHoldAnyNumberOfNodes) {
  const VoxelGrid grid = grids().back();
  const std::vector<Vec3> positions = positions_about(grid, {}, 640);
  std::vector<int> all(positions.size());
  std::iota(all.begin(), all.end(), 0);
  on_each_target([&] {
    for (std::size_t count = 0; count <= VoxelBlock::capacity; ++count) {
      expect_as_scalar(grid, {}, positions, std::span(all).subspan(5 * count, count));
    }
  });
}

}  // namespace
}  // namespace musclebench
