#include "core/effects/no_passage/stencil.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

constexpr auto node_face = StencilKind::node_face;
constexpr auto edge_edge = StencilKind::edge_edge;

Vec3 random_point(std::mt19937_64& random) {
  const auto number = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const double x = number();
  const double y = number();
  return {x, y, number()};
}

StencilCorners random_corners(std::mt19937_64& random) {
  return {random_point(random), random_point(random), random_point(random), random_point(random)};
}

/// By a grid of points on both sides: an upper bound that is off by less than 0.03.
double sampled_distance(StencilKind kind, const StencilCorners& corners) {
  constexpr int samples = 40;
  double least = INFINITY;
  for (int i = 0; i <= samples; ++i) {
    for (int j = 0; j <= samples; ++j) {
      const double s = static_cast<double>(i) / samples;
      const double t = static_cast<double>(j) / samples;
      const auto& [a, b, c, d] = corners;
      if (kind == edge_edge) {
        least = std::min(least, (a + s * (b - a) - c - t * (d - c)).norm());
      } else if (s + t <= 1) {
        least = std::min(least, (a - b - s * (c - b) - t * (d - b)).norm());
      }
    }
  }
  return least;
}

TEST(Stencil, GapIsTheLeastDistance) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 300; ++i) {
    const StencilCorners corners = random_corners(random);
    for (const StencilKind kind : {node_face, edge_edge}) {
      const StencilGap gap = gap_of(kind, corners);
      const double sampled = sampled_distance(kind, corners);
      EXPECT_LE(gap.distance_m, sampled + 1e-12);
      EXPECT_GT(gap.distance_m, sampled - 0.03);
      Vec3 apart = Vec3::Zero();
      double sum = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        apart += gap.weights[k] * corners[k];
        sum += gap.weights[k];
      }
      EXPECT_NEAR(sum, 0, 1e-12);
      EXPECT_LT((apart - gap.apart).norm(), 1e-9);
    }
  }
}

TEST(Stencil, EdgesWithoutAngleOrLengthHaveAGap) {
  const Vec3 x = Vec3::UnitX();
  const Vec3 z = Vec3::UnitZ();
  EXPECT_NEAR(gap_of(edge_edge, {Vec3::Zero(), x, z, z + x}).distance_m, 1, 1e-15);
  EXPECT_NEAR(gap_of(edge_edge, {Vec3::Zero(), x, z + 3 * x, z + 5 * x}).distance_m, std::sqrt(5.0), 1e-15);
  EXPECT_NEAR(gap_of(edge_edge, {Vec3::Zero(), x, z + 0.5 * x, z + 0.5 * x}).distance_m, 1, 1e-15);
  EXPECT_NEAR(gap_of(edge_edge, {x, x, z, z}).distance_m, std::sqrt(2.0), 1e-15);
}

TEST(Stencil, NodeStopsBeforeTheFaceThatItWouldPass) {
  const Vec3 z = Vec3::UnitZ();
  const StencilCorners start = {z, Vec3(-1, -1, 0), Vec3(2, -1, 0), Vec3(-1, 2, 0)};
  StencilCorners end = start;
  end[0] = -9 * z;
  const double share = safe_share(node_face, start, end, 0.01);
  EXPECT_LT(share, 0.099);
  EXPECT_GT(share, 0.08);
}

TEST(Stencil, CommonMotionStopsNothing) {
  std::mt19937_64 random(2);
  const StencilCorners start = random_corners(random);
  StencilCorners end = start;
  for (Vec3& corner : end) corner += Vec3(100, -20, 3);
  EXPECT_EQ(safe_share(node_face, start, end, 1e-6), 1);
  EXPECT_EQ(safe_share(edge_edge, start, end, 1e-6), 1);
}

TEST(Stencil, NoSafePathComesCloserThanItMay) {
  std::mt19937_64 random(3);
  int stopped = 0;
  for (int i = 0; i < 2000; ++i) {
    const StencilCorners start = random_corners(random);
    StencilCorners end = random_corners(random);
    for (const StencilKind kind : {node_face, edge_edge}) {
      const double least_m = 0.2 * gap_of(kind, start).distance_m;
      const double share = safe_share(kind, start, end, least_m);
      stopped += share < 1 ? 1 : 0;
      for (int step = 0; step <= 100; ++step) {
        StencilCorners at;
        for (std::size_t k = 0; k < 4; ++k) at[k] = start[k] + 0.01 * step * share * (end[k] - start[k]);
        ASSERT_GE(gap_of(kind, at).distance_m, least_m * (1 - 1e-9));
      }
    }
  }
  EXPECT_GT(stopped, 400);
  EXPECT_LT(stopped, 3600);
}

}  // namespace
}  // namespace musclebench
