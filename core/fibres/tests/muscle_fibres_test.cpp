#include "core/fibres/muscle_fibres.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "core/fibres/moment_arm.hpp"
#include "core/fibres/tests/bent_bar.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {
namespace {

constexpr int segments = 16;

FibrePaths paths_of(const test::Bar& bar, int count) {
  const SignedSurface surface = test::surface_of(bar.mesh);
  const FibreAreas areas = fibre_areas(bar.mesh, bar.start_nodes, bar.end_nodes);
  const VolumePotential potential(bar.mesh, surface, areas, {}, 20'000);
  return trace_fibres(potential, bar.mesh, surface, areas, count, segments);
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

TEST(MuscleFibres, RunFromEndToEndOfABar) {
  const test::Bar bar = test::make_bar(0.1, 0.012, 8);
  const FibrePaths paths = paths_of(bar, 50);
  EXPECT_EQ(paths.lost, 0);
  ASSERT_EQ(paths.fibres.size(), 50U);
  for (const FibrePath& fibre : paths.fibres) {
    EXPECT_NEAR(fibre.points.front().x(), 0, 1e-12);
    EXPECT_NEAR(fibre.points.back().x(), 0.1, 1e-12);
    ASSERT_EQ(fibre.points.size(), segments + 1U);
    for (std::size_t i = 1; i < fibre.points.size(); ++i) {
      EXPECT_NEAR(fibre.points[i].y(), fibre.points.front().y(), 1e-3);
    }
  }
  // They share the section evenly: a quarter of them in each quarter.
  const auto quarter = std::count_if(paths.fibres.begin(), paths.fibres.end(), [](const FibrePath& fibre) {
    return fibre.points[8].y() > 0 && fibre.points[8].z() > 0;
  });
  EXPECT_NEAR(static_cast<double>(quarter), 12.5, 2);
}

/// They begin evenly over the ring's end; on their way they are drawn inwards, where it is shorter.
TEST(MuscleFibres, ShareTheEndOfARingEvenly) {
  const double turn = 0.5 * std::numbers::pi;
  const test::Bar bar = test::bent_bar(test::make_bar(0.08, 0.01, 24), 0.03, turn);
  const FibrePaths paths = paths_of(bar, 200);
  EXPECT_EQ(paths.lost, 0);
  const MuscleFibres fibres(bar.mesh, paths, "ring", 1);
  const std::vector<double> lengths = fibres.lengths(fibres.points(bar.mesh.vertices));
  EXPECT_NEAR(mean(lengths), turn * 0.0295, 5e-4);
  EXPECT_GT(*std::min_element(lengths.begin(), lengths.end()), turn * 0.0195);
  EXPECT_LT(*std::max_element(lengths.begin(), lengths.end()), turn * 0.0405);
}

TEST(MuscleFibres, MoveWithTheirMuscle) {
  const test::Bar bar = test::bent_bar(test::make_bar(0.08, 0.01, 12), 0.03, 2);
  const MuscleFibres fibres(bar.mesh, paths_of(bar, 10), "ring", 2);
  const std::vector<Vec3> rest = fibres.points(bar.mesh.vertices);
  RigidMotion motion;
  motion.rotation = Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  motion.translation_m = Vec3(0.1, -0.2, 0.3);
  std::vector<Vec3> moved;
  for (const Vec3& node : bar.mesh.vertices) moved.push_back(motion.apply(node));
  const std::vector<Vec3> points = fibres.points(moved);
  for (std::size_t i = 0; i < rest.size(); ++i) EXPECT_LT((points[i] - motion.apply(rest[i])).norm(), 1e-14);
}

/// A band that a turning wheel winds up to three times its length: each fibre grows by its own radius. Mean value
/// coordinates, which look at the whole surface, flatten its curve a little.
TEST(MuscleFibres, OfABandOverACylinderHaveItsRadiusForMomentArm) {
  const test::Bar straight = test::make_bar(0.08, 0.002, 30);
  const double radius = 0.03;
  const double first_turn = 1;
  const test::Bar bar = test::bent_bar(straight, radius, first_turn);
  const MuscleFibres fibres(bar.mesh, paths_of(bar, 20), "band", 2);
  std::vector<double> angles;
  std::vector<double> means;
  for (int frame = 0; frame <= 20; ++frame) {
    angles.push_back(0.05 * frame);
    means.push_back(mean(fibres.lengths(fibres.points(test::bent(straight, radius, first_turn + angles.back())))));
  }
  for (const auto& arm : moment_arms(angles, means)) EXPECT_NEAR(arm->arm_m, radius, 0.02 * radius);
}

TEST(MuscleFibres, AreTheSameForAnyNumberOfThreads) {
  const test::Bar bar = test::bent_bar(test::make_bar(0.08, 0.01, 12), 0.03, 2);
  const FibrePaths paths = paths_of(bar, 10);
  const auto one = MuscleFibres(bar.mesh, paths, "ring", 1).points(bar.mesh.vertices);
  const auto two = MuscleFibres(bar.mesh, paths, "ring", 2).points(bar.mesh.vertices);
  EXPECT_EQ(one, two);
}

}  // namespace
}  // namespace musclebench
