#include "backends/sdf/grid/cubic_kernel.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/grid/gather_nodes.hpp"
#include "backends/sdf/grid/tests/field_samples.hpp"
#include "backends/sdf/grid/tests/query_positions.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

using Wanted = CubicField::Wanted;

/// Values without any pattern, on cells that are no cubes.
CubicField noisy_field() {
  GridShape shape;
  shape.lower_m = Vec3(-1, -0.9, -1.1);
  shape.cell_size_m = Vec3(2.0 / 3, 2.0 / 5, 2.0 / 4);
  shape.cells = {3, 5, 4};
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  return interpolate(shape, [&](const Vec3&) { return noise(generator); });
}

/// A ball in the middle of its domain.
CubicField ball_field() {
  const RepairedMesh bone{make_sphere(0.1, 4), true, {}};
  GridShape shape = grid_over(bone.mesh, {.cells = 19}, "bone");
  shape.cell_size_m *= 1.5;
  shape.lower_m *= 1.5;
  return build_field(SignedSurface(bone), shape, 1);
}

struct Answer {
  Vec3 cells;
  FieldSample sample;
};

/// By node.
std::vector<std::optional<Answer>> query_all(const CubicField& field, const RigidMotion& pose,
                                             const std::vector<Vec3>& positions, std::span<const int> nodes,
                                             Wanted wanted = Wanted::known) {
  const CellMap map(field.shape(), pose);
  std::vector<std::optional<Answer>> answers(positions.size());
  FieldBlock block;
  std::size_t last = 0;
  for (std::size_t next = 0; next < nodes.size();) {
    block.count = 0;
    const std::size_t first = next;
    next = field.sample(map, positions, nodes, next, wanted, block);
    EXPECT_GT(next, first);
    EXPECT_LE(block.count, FieldBlock::capacity);
    for (std::size_t n = 0; n < block.count; ++n) {
      EXPECT_TRUE(block.query[n] >= first && block.query[n] < next && (n == 0 || block.query[n] > last));
      last = block.query[n];
      answers[static_cast<std::size_t>(nodes[last])] =
          Answer{block.cells(n), {block.value_m[n], {block.slope_x[n], block.slope_y[n], block.slope_z[n]}}};
    }
  }
  return answers;
}

void expect_equal(const std::optional<Answer>& one, const std::optional<Answer>& other) {
  ASSERT_EQ(one.has_value(), other.has_value());
  if (one) {
    ASSERT_EQ(one->cells, other->cells);
    ASSERT_EQ(one->sample.value_m, other->sample.value_m);
    ASSERT_EQ(one->sample.gradient, other->sample.gradient);
  }
}

/// Against the plain code of CubicCell.
TEST(CubicKernel, EvaluatesWhatTheCellsSay) {
  const CubicField field = noisy_field();
  const GridShape& shape = field.shape();
  const std::vector<Vec3> positions = positions_about(shape, oblique_pose(), 700);
  const auto answers = query_all(field, oblique_pose(), positions, all_of(positions));
  std::size_t found = 0;
  for (std::size_t n = 0; n < positions.size(); ++n) {
    const Vec3 rest = oblique_pose().apply_inverse(positions[n]);
    const Vec3 cells = (rest - shape.lower_m).cwiseQuotient(shape.cell_size_m);
    ASSERT_EQ(answers[n].has_value(), shape.contains(cells)) << n;
    if (answers[n]) {
      ++found;
      EXPECT_NEAR((answers[n]->cells - cells).norm(), 0, 1e-14);
      const CellPosition in_cell = shape.locate(answers[n]->cells);
      Vec3 slope;
      const double value = field.cell(in_cell.i, in_cell.j, in_cell.k).value_and_gradient(in_cell.at, slope);
      EXPECT_NEAR(answers[n]->sample.value_m, value, 1e-15);
      EXPECT_NEAR((answers[n]->sample.gradient - slope.cwiseQuotient(shape.cell_size_m)).norm(), 0, 1e-14);
    }
  }
  EXPECT_GT(found, 300U);
  EXPECT_LT(found, 600U);
}

TEST(CubicKernel, KnowsTheBorderOfTheDomain) {
  // Cells of 1 m, so that the border is hit to the bit.
  GridShape shape;
  shape.cells = {2, 3, 2};
  const CubicField field =
      // Whole numbers at all nodes, which are thirds of a cell apart.
      interpolate(shape, [](const Vec3& p) { return std::round(3 * p.x() - 6 * p.y() + 9 * p.z()); });
  const double beyond = std::nextafter(2.0, 3.0);
  const std::vector<Vec3> positions{{0, 0, 0},      {2, 3, 2},      {2, 0.5, 1},     {1, 1, 1},
                                    {beyond, 1, 1}, {1, 1, beyond}, {-1e-300, 1, 1}, {1, -0.0, 1}};
  const auto answers = query_all(field, {}, positions, all_of(positions));
  for (const std::size_t n : {0U, 1U, 2U, 3U, 7U}) {
    const Vec3& p = positions[n];
    ASSERT_TRUE(answers[n]) << n;
    EXPECT_NEAR(answers[n]->sample.value_m, 3 * p.x() - 6 * p.y() + 9 * p.z(), 1e-14) << n;
    EXPECT_NEAR((answers[n]->sample.gradient - Vec3(3, -6, 9)).norm(), 0, 1e-13) << n;
  }
  for (const std::size_t n : {4U, 5U, 6U}) {
    EXPECT_FALSE(answers[n]) << n;
  }
}

TEST(CubicKernel, AnAnswerDoesNotDependOnWhoElseAsks) {
  const CubicField field = noisy_field();
  const std::vector<Vec3> positions = positions_about(field.shape(), oblique_pose(), 400);
  const std::vector<int> nodes = all_of(positions);
  const auto together = query_all(field, oblique_pose(), positions, nodes);
  for (const std::size_t length : {0U, 1U, 2U, 3U, 5U, 7U, 8U, 9U, 15U, 16U, 17U, 127U, 128U, 129U, 300U}) {
    const std::size_t first = 11 + length / 5;
    const auto some = query_all(field, oblique_pose(), positions, std::span(nodes).subspan(first, length));
    for (std::size_t n = 0; n < positions.size(); ++n) {
      expect_equal(some[n], n >= first && n < first + length ? together[n] : std::nullopt);
    }
  }
  std::vector<int> every_third;
  for (int node = 0; node < static_cast<int>(positions.size()); node += 3) {
    every_third.push_back(node);
  }
  const auto some = query_all(field, oblique_pose(), positions, every_third);
  for (std::size_t n = 0; n < positions.size(); ++n) {
    expect_equal(some[n], n % 3 == 0 ? together[n] : std::nullopt);
  }
}

TEST(CubicKernel, AsksOnlyWhereItIsWanted) {
  const CubicField field = ball_field();
  const GridShape& shape = field.shape();
  const std::vector<Vec3> positions = positions_about(shape, oblique_pose(), 3000);
  const auto known = query_all(field, oblique_pose(), positions, all_of(positions));
  const auto inside = query_all(field, oblique_pose(), positions, all_of(positions), Wanted::may_be_inside);
  std::size_t left_out = 0;
  for (std::size_t n = 0; n < positions.size(); ++n) {
    const Vec3 cells = CellMap(shape, oblique_pose()).apply(positions[n]);
    if (!shape.contains(cells)) {
      EXPECT_FALSE(known[n] || inside[n]);
      continue;
    }
    const CellPosition in_cell = shape.locate(cells);
    const std::size_t cell = shape.cell(in_cell.i, in_cell.j, in_cell.k);
    ASSERT_TRUE(known[n]);
    EXPECT_EQ(inside[n].has_value(), field.may_be_negative(cell));
    left_out += static_cast<std::size_t>(!inside[n]);
    Vec3 slope;
    const double value = field.cell(in_cell.i, in_cell.j, in_cell.k).value_and_gradient(in_cell.at, slope);
    EXPECT_NEAR(known[n]->sample.value_m, value, 1e-15);
    if (inside[n]) {
      expect_equal(inside[n], known[n]);
    }
  }
  EXPECT_GT(left_out, 300U);
}

/// Every kind of SIMD that this machine has gives the same bits as the one without.
TEST(CubicKernel, GivesTheSameBitsOnEveryMachine) {
  const std::vector<std::int64_t> targets = [] {
    std::vector<std::int64_t> result;
    for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) {
      result.push_back(rest & -rest);
    }
    return result;
  }();
  for (const CubicField& field : {noisy_field(), ball_field()}) {
    const std::vector<Vec3> positions = positions_about(field.shape(), oblique_pose(), 1000);
    std::optional<std::vector<std::optional<Answer>>> expected;
    for (const std::int64_t target : targets) {
      hwy::GetChosenTarget().Update(target);
      const auto answers = query_all(field, oblique_pose(), positions, all_of(positions));
      hwy::GetChosenTarget().DeInit();
      if (!expected) {
        expected = answers;
      }
      for (std::size_t n = 0; n < positions.size(); ++n) {
        expect_equal(answers[n], (*expected)[n]);
      }
    }
  }
}

}  // namespace
}  // namespace musclebench
