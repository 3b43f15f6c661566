#include "core/fibres/volume_potential.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/fibres/tests/bent_bar.hpp"

namespace musclebench {
namespace {

VolumePotential potential_of(const test::Bar& bar, const std::vector<FibreSegment>& guides = {}) {
  return {bar.mesh, test::surface_of(bar.mesh), fibre_areas(bar.mesh, bar.start_nodes, bar.end_nodes), guides, 20'000};
}

TEST(VolumePotential, IsLinearInABar) {
  const VolumePotential potential = potential_of(test::make_bar(0.1, 0.012, 8));
  const double cell = potential.cell_size_m();
  for (const double x : {0.01, 0.03, 0.05, 0.09}) {
    const auto value = potential.at(Vec3(x, 0.004, -0.009));
    EXPECT_NEAR(value.potential, x / 0.1, cell / 0.1);
    EXPECT_GT(value.flow.normalized().x(), 1 - 1e-4);
  }
}

/// In a ring the function is the angle, whatever the radius.
TEST(VolumePotential, IsTheAngleInARing) {
  const double turn = 0.75 * std::numbers::pi;
  const double radius = 0.03;
  const VolumePotential potential = potential_of(test::bent_bar(test::make_bar(0.08, 0.01, 24), radius, turn));
  for (const double share : {0.2, 0.5, 0.7}) {
    for (const double off : {-0.007, 0.0, 0.007}) {
      const double angle = share * turn;
      const Vec3 outward(std::cos(angle), std::sin(angle), 0);
      const auto value = potential.at((radius + off) * outward);
      EXPECT_NEAR(value.potential, share, 0.02);
      EXPECT_GT(value.flow.normalized().dot(Vec3(-outward.y(), outward.x(), 0)), 0.995);
    }
  }
}

/// Fibres measured askew turn the flow in the middle of a wide block, as far as its walls let them.
TEST(VolumePotential, FollowsMeasuredFibres) {
  const test::Bar block = test::make_bar(0.05, 0.04, 12);
  const Vec3 askew = Vec3(1, 0.5, 0).normalized();
  std::vector<FibreSegment> guides;
  for (const double y : {-0.02, 0.0, 0.02}) {
    const Vec3 middle(0.025, y, 0);
    guides.push_back({middle - 0.01 * askew, middle + 0.01 * askew});
  }
  const Vec3 plain = potential_of(block).at(Vec3(0.025, 0.001, 0.001)).flow.normalized();
  const Vec3 guided = potential_of(block, guides).at(Vec3(0.025, 0.001, 0.001)).flow.normalized();
  EXPECT_GT(plain.x(), 0.9999);
  EXPECT_GT(guided.dot(askew), 0.98);
  EXPECT_GT(guided.dot(askew), plain.dot(askew) + 0.08);
}

TEST(VolumePotential, IsConstantWhereAnAreaIsOutOfReach) {
  test::Bar bar = test::make_bar(0.1, 0.012, 8);
  bar.end_nodes.clear();
  EXPECT_TRUE(potential_of(bar).seeds(10).empty());
}

/// A grid in metres that are kilometres, or micrometres, is the same grid.
TEST(VolumePotential, IsFreeOfScale) {
  test::Bar bar = test::bent_bar(test::make_bar(0.1, 0.012, 8), 0.05, 2);
  const VolumePotential potential = potential_of(bar);
  for (const double scale : {1024.0, 1.0 / 1024}) {
    test::Bar scaled = bar;
    for (Vec3& vertex : scaled.mesh.vertices) vertex *= scale;
    const VolumePotential other = potential_of(scaled);
    const Vec3 point(0.05 * std::cos(0.7), 0.05 * std::sin(0.7), 0.003);
    EXPECT_NEAR(other.at(scale * point).potential, potential.at(point).potential, 1e-6);
    EXPECT_EQ(other.seeds(20).size(), potential.seeds(20).size());
  }
}

}  // namespace
}  // namespace musclebench
