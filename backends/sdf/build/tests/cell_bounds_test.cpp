#include "backends/sdf/build/cell_bounds.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace musclebench {
namespace {

class CellBoundsWithEachTarget : public testing::Test {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_F(CellBoundsWithEachTarget, AreThoseOfEachCell) {
  std::mt19937 generator(2);
  std::normal_distribution<double> normal(0, 1);
  const Vec3 size_m(0.3, 0.02, 1.7);
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    for (std::size_t count = 1; count <= CellBounds::width; ++count) {
      std::vector<CubicCell> cells(count);
      for (CubicCell& cell : cells) {
        for (CubicCell::Along& along : cell.axis) {
          for (CubicCell::Edges* edges : {&along.low, &along.first, &along.second, &along.high}) {
            *edges = CubicCell::Edges(normal(generator), normal(generator), normal(generator), normal(generator));
          }
        }
      }
      CellBounds bounds{};
      bound_cells(cells, size_m, bounds);
      for (std::size_t n = 0; n < count; ++n) {
        const CubicCell::Bernstein expected = cells[n].bernstein();
        EXPECT_EQ(bounds.lowest[n], *std::min_element(expected.begin(), expected.end()));
        EXPECT_EQ(bounds.highest[n], *std::max_element(expected.begin(), expected.end()));
        const double lipschitz_bound = CubicCell::lipschitz_bound(expected, size_m);
        EXPECT_GE(bounds.lipschitz_bound[n], lipschitz_bound * (1 - 1e-14));
        EXPECT_LE(bounds.lipschitz_bound[n], 3 * lipschitz_bound);
      }
    }
  }
}

}  // namespace
}  // namespace musclebench
