#include "core/mesh_repair/sharp_features.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_sampler.hpp"

namespace musclebench {
namespace {

double sharp_share(const TriangleMesh& mesh, const SharpFeatures& features) {
  const SurfaceSampler sampler(mesh);
  RandomNumbers random(5);
  constexpr int count = 20000;
  int sharp = 0;
  for (int i = 0; i < count; ++i) {
    sharp += features.near(sampler.draw(random).point) ? 1 : 0;
  }
  return static_cast<double>(sharp) / count;
}

TEST(SharpFeatures, ASphereIsSmoothEverywhere) {
  for (const double radius_m : {1e-3, 1.0, 1e3}) {
    const TriangleMesh sphere = make_sphere(radius_m, 4);
    const SharpFeatures features(sphere);
    EXPECT_EQ(features.edges(), 0);
    EXPECT_EQ(features.vertices(), 0);
    EXPECT_EQ(sharp_share(sphere, features), 0);
  }
}

TEST(SharpFeatures, ACubeIsSharpAlongItsEdgesAndNowhereElse) {
  for (const int cells : {1, 10, 40}) {
    const TriangleMesh cube = make_box({0.5, 0.5, 0.5}, cells);
    const SharpFeatures features(cube);
    EXPECT_EQ(features.edges(), 12 * cells);
    EXPECT_EQ(features.vertices(), 12 * (cells - 1) + 8);
    EXPECT_LE(features.radius_m(), 0.01 * std::sqrt(3.0) * (1 + 1e-12));
    // Four strips along the border of each face.
    const double flat = 1 - 2 * features.radius_m();
    EXPECT_NEAR(sharp_share(cube, features), 1 - flat * flat, 0.01);
    EXPECT_TRUE(features.near({0.5, 0.5 - 0.99 * features.radius_m(), 0.1}));
    EXPECT_FALSE(features.near({0.5, 0.5 - 1.01 * features.radius_m(), 0.1}));
  }
}

TEST(SharpFeatures, TheTipOfAConeIsSharpThoughNoneOfItsEdgesIs) {
  TriangleMesh cone;
  constexpr int around = 64;
  cone.vertices = {{0, 0, 1}, {0, 0, 0}};
  for (int i = 0; i < around; ++i) {
    const double angle = 2 * std::numbers::pi * i / around;
    cone.vertices.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  for (int i = 0; i < around; ++i) {
    cone.triangles.push_back({0, 2 + i, 2 + (i + 1) % around});
    cone.triangles.push_back({1, 2 + (i + 1) % around, 2 + i});
  }
  const SharpFeatures features(cone);
  EXPECT_EQ(features.edges(), around);  // the rim of the base
  EXPECT_EQ(features.vertices(), around + 1);
  EXPECT_TRUE(features.near({0, 0, 1}));
  EXPECT_FALSE(features.near({0, 0, 0}));
}

TEST(SharpFeatures, RimsAndFinsAreSharp) {
  TriangleMesh fin;
  fin.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  fin.triangles = {{0, 1, 2}};
  EXPECT_EQ(SharpFeatures(fin).edges(), 3);
  fin.triangles = {{0, 1, 2}, {2, 1, 0}};
  EXPECT_EQ(SharpFeatures(fin).edges(), 3);
  EXPECT_EQ(SharpFeatures(fin).vertices(), 3);
}

}  // namespace
}  // namespace musclebench
