#include "backends/sdf/grid/cubic_field.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/grid/tests/field_samples.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/tests/random_points.hpp"

namespace musclebench {
namespace {

GridShape cube_grid(int cells) {
  GridShape shape;
  shape.lower_m = Vec3::Constant(-1);
  shape.cell_size_m = Vec3::Constant(2.0 / cells);
  shape.cells = {cells, cells, cells};
  return shape;
}

double sphere(const Vec3& point) { return point.norm() - 0.7; }

RepairedMesh clean_surface(TriangleMesh mesh) { return {std::move(mesh), true, {}}; }

TEST(GridShape, FieldOf64CellsStaysBelow7700000Bytes) {
  const CubicField field(cube_grid(64));
  EXPECT_EQ(field.values().size() * sizeof(float), 7655700U);
  EXPECT_LE(field.bytes(), 7700000U);
  EXPECT_EQ(CubicField::bytes_needed(field.shape()), static_cast<double>(field.bytes()));
  EXPECT_EQ(field.shape().node_count(), 1897025U);
}

TEST(GridShape, EveryNodeHasAnOffsetOfItsOwn) {
  GridShape shape = cube_grid(3);
  shape.cells = {3, 4, 2};
  std::vector<int> uses(shape.value_count(), 0);
  std::size_t nodes = 0;
  for_each_node(shape, [&](std::size_t offset, const Vec3&) {
    ++uses.at(offset);
    ++nodes;
  });
  EXPECT_EQ(nodes, shape.node_count());
  EXPECT_EQ(std::count(uses.begin(), uses.end(), 1), static_cast<long>(nodes));
}

TEST(CubicField, ReproducesCubicsOverStretchedCells) {
  GridShape shape;
  shape.lower_m = Vec3(-1, -1, -1);
  shape.cell_size_m = Vec3(2.0 / 3, 2.0 / 5, 2.0 / 4);
  shape.cells = {3, 5, 4};
  const auto cubic = [](const Vec3& p) {
    return 1 + p.x() - 2 * p.y() * p.z() + p.x() * p.x() * p.y() - p.z() * p.z() * p.z() + 3 * p.x() * p.y() * p.z();
  };
  const auto slope = [](const Vec3& p) {
    return Vec3(1 + 2 * p.x() * p.y() + 3 * p.y() * p.z(), -2 * p.z() + p.x() * p.x() + 3 * p.x() * p.z(),
                -2 * p.y() - 3 * p.z() * p.z() + 3 * p.x() * p.y());
  };
  const CubicField field = interpolate(shape, cubic);
  for (const Vec3& point : random_points(1, 200, 9)) {
    EXPECT_NEAR(*field.value(point), cubic(point), 2e-6);
    const std::optional<FieldSample> sample = field.sample(point);
    EXPECT_NEAR(sample->value_m, cubic(point), 2e-6);
    EXPECT_NEAR((sample->gradient - slope(point)).norm(), 0, 3e-5);
  }
}

TEST(CubicField, IsContinuousAcrossFaces) {
  std::mt19937 generator(3);
  std::normal_distribution<double> noise;
  const CubicField field = interpolate(cube_grid(4), [&](const Vec3&) { return noise(generator); });
  std::uniform_real_distribution<double> unit(0, 1);
  for (std::size_t i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 at(unit(generator), unit(generator), unit(generator));
      const std::array<std::size_t, 3> step{axis == 0 ? 1U : 0U, axis == 1 ? 1U : 0U, axis == 2 ? 1U : 0U};
      at[axis] = 1;
      const double before = field.cell(i, i, i).value(at);
      at[axis] = 0;
      EXPECT_NEAR(field.cell(i + step[0], i + step[1], i + step[2]).value(at), before, 1e-13);
    }
  }
}

TEST(CubicField, KnowsNothingOutsideItsDomain) {
  const CubicField field = interpolate(cube_grid(2), sphere);
  EXPECT_FALSE(field.value({1.001, 0, 0}));
  EXPECT_FALSE(field.sample({0, 0, -1.001}));
  EXPECT_FALSE(field.value({0, std::nan(""), 0}));
  EXPECT_TRUE(field.value({1, 1, 1}));
  EXPECT_TRUE(field.value({-1, -1, -1}));
}

TEST(CubicField, HalvingTheCellsOfASphereDividesTheErrorByEight) {
  double last = 0;
  for (const int cells : {8, 16, 32}) {
    const CubicField field = interpolate(cube_grid(cells), sphere);
    double largest = 0;
    for (const Vec3& point : random_points(1, 20000, 9)) {
      if (point.norm() > 0.5) {  // the centre, where distance has a kink, is left out
        largest = std::max(largest, std::abs(*field.value(point) - sphere(point)));
      }
    }
    if (cells > 8) {
      EXPECT_GE(last / largest, 8) << cells;
    }
    last = largest;
  }
  EXPECT_LT(last, 1e-4);
}

TEST(CubicField, ErrorOfABoxFallsWithItsCells) {
  const RepairedMesh box = clean_surface(make_box({0.5, 0.4, 0.3}, 2));
  const SignedSurface surface(box);
  double last = 0;
  for (const int cells : {9, 18, 36}) {
    const CubicField field = build_field(surface, grid_over(box.mesh, {.cells = cells}, "box"), 1);
    const FieldError error = estimate_error(field, surface, 20000);
    EXPECT_EQ(error.samples, 20000);
    EXPECT_LE(error.largest_m, 0.5 * field.shape().cell_size_m.maxCoeff());
    if (cells > 9) {
      EXPECT_GE(last / error.largest_m, 1.8) << cells;
    }
    last = error.largest_m;
  }
}

TEST(CubicField, SinglePrecisionIsOnlyRounded) {
  const CubicField coarse = interpolate(cube_grid(8), sphere);
  for_each_node(coarse.shape(), [&](std::size_t offset, const Vec3& position) {
    EXPECT_EQ(coarse.stored(offset), static_cast<double>(static_cast<float>(sphere(position))));
  });
}

}  // namespace
}  // namespace musclebench
