#include "backends/sdf/build/rough_bounds.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "backends/sdf/grid/cubic_field.hpp"

namespace musclebench {
namespace {

GridShape row_of_cells(const Vec3& cell_size_m) {
  GridShape shape;
  shape.cell_size_m = cell_size_m;
  shape.cells = {static_cast<std::int32_t>(RoughBounds::capacity), 1, 1};
  return shape;
}

RoughBounds bounds_of(const CubicField& field, std::size_t first, std::size_t count) {
  const auto row = [&](std::size_t j, std::size_t k) {
    return field.single_values().data() + field.shape().record(first, j, k);
  };
  RoughBounds bounds;
  bound_roughly({row(0, 0), row(0, 1), row(1, 0), row(1, 1)}, count, field.shape().cell_size_m, bounds);
  return bounds;
}

class RoughBoundsWithEachTarget : public testing::Test {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  template <typename Check>
  static void with_each_target(Check&& check) {
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      SCOPED_TRACE(hwy::TargetName(target));
      hwy::SetSupportedTargetsForTest(target);
      check();
    }
  }
};

TEST_F(RoughBoundsWithEachTarget, AreNeverTooTight) {
  std::mt19937 generator(3);
  const Vec3 size_m(0.3, 0.02, 1.7);
  CubicField field(row_of_cells(size_m), FieldPrecision::single_precision);
  with_each_target([&] {
    for (const float spread : {1.0F, 1e-3F, 1e-6F}) {
      std::normal_distribution<float> normal(1, spread);
      std::generate(field.single_values().begin(), field.single_values().end(), [&] { return normal(generator); });
      for (const std::size_t count : {std::size_t{1}, std::size_t{17}, RoughBounds::capacity}) {
        const std::size_t begin = RoughBounds::capacity - count;
        const RoughBounds bounds = bounds_of(field, begin, count);
        for (std::size_t n = 0; n < count; ++n) {
          const CubicCell cell = field.cell(begin + n, 0, 0);
          const CubicCell::Bernstein expected = cell.bernstein();
          EXPECT_LE(bounds.lowest[n], *std::min_element(expected.begin(), expected.end()));
          EXPECT_GE(bounds.steepest[n] * RoughBounds::growth, CubicCell::steepest(expected, size_m));
          EXPECT_EQ(bounds.lowest_corner[n], cell.axis[0].low.min(cell.axis[0].high).minCoeff());
        }
      }
    }
  });
}

TEST_F(RoughBoundsWithEachTarget, AreTightWhereTheFieldIsAPlane) {
  const Vec3 size_m(0.3, 0.02, 1.7);
  const Vec3 slope(0.4, -0.8, 0.2);
  CubicField field(row_of_cells(size_m), FieldPrecision::single_precision);
  const GridShape& shape = field.shape();
  for (std::size_t vertex = 0; vertex < shape.vertex_count(); ++vertex) {
    const std::size_t i = vertex % (shape.count(0) + 1);
    const std::size_t j = vertex / (shape.count(0) + 1) % 2;
    const std::size_t k = vertex / (shape.count(0) + 1) / 2;
    const Vec3 at = size_m.cwiseProduct(Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
    const std::size_t record = shape.record(i, j, k);
    field.store(record, 1 + slope.dot(at));
    for (std::size_t third = 1; third < 3; ++third) {
      const double share = static_cast<double>(third) / 3;
      field.store(record + third, 1 + slope.dot(at) + share * slope.y() * size_m.y());
      field.store(record + 2 + third, 1 + slope.dot(at) + share * slope.z() * size_m.z());
      if (i < shape.count(0)) {
        field.store(record + 4 + third, 1 + slope.dot(at) + share * slope.x() * size_m.x());
      }
    }
  }
  with_each_target([&] {
    const RoughBounds bounds = bounds_of(field, 0, RoughBounds::capacity);
    for (std::size_t n = 0; n < RoughBounds::capacity; ++n) {
      EXPECT_NEAR(bounds.lowest[n], bounds.lowest_corner[n], 1e-3);
      EXPECT_NEAR(bounds.steepest[n], slope.norm(), 2e-2);
    }
  });
}

}  // namespace
}  // namespace musclebench
