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

/// On a measured fibre its direction, whichever way round it was measured; far from all, its own.
TEST(VolumePotential, FollowsMeasuredFibres) {
  const test::Bar block = test::make_bar(0.05, 0.04, 12);
  const Vec3 askew = Vec3(1, 0.5, 0).normalized();
  const std::vector<FibreSegment> guides = {
      {Vec3(0.025, -0.02, 0) - 0.01 * askew, Vec3(0.025, -0.02, 0) + 0.01 * askew},
      {Vec3(0.025, 0.02, 0) + 0.01 * askew, Vec3(0.025, 0.02, 0) - 0.01 * askew}};
  const VolumePotential potential = potential_of(block, guides);
  const auto direction_at = [&](double y, double z) { return potential.at(Vec3(0.025, y, z)).flow.normalized(); };
  for (const double y : {-0.02, 0.02}) EXPECT_GT(direction_at(y, 0).dot(askew), 0.999);
  EXPECT_LT(direction_at(0.015, 0).x(), 0.96);
  EXPECT_GT(direction_at(0, 0.038).x(), 0.998);
  EXPECT_GT(potential_of(block).at(Vec3(0.025, 0, 0)).flow.normalized().x(), 0.9999);
}

/// A fibre across the flow does not stop it.
TEST(VolumePotential, IsTurnedBySixtyDegreesAtMost) {
  const test::Bar block = test::make_bar(0.05, 0.04, 12);
  const VolumePotential potential = potential_of(block, {{Vec3(0.025, -0.01, 0), Vec3(0.0249, 0.01, 0)}});
  EXPECT_GE(potential.at(Vec3(0.025, 0, 0)).flow.normalized().x(), 0.5);
}

TEST(VolumePotential, IsNoneWhereAnAreaIsOutOfReach) {
  test::Bar bar = test::make_bar(0.1, 0.012, 8);
  bar.end_nodes.clear();
  EXPECT_FALSE(potential_of(bar).flows());
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
  }
}

}  // namespace
}  // namespace musclebench
