#include "core/measure/depth_limit.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

TEST(Thickness, IsThatOfAPlateAndNoOtherForAFinerMeshOrAnotherOrientation) {
  const TriangleMesh plate = make_box({1, 1, 0.001}, 4);
  EXPECT_NEAR(thickness_m(plate), 0.002, 1e-5);
  EXPECT_NEAR(thickness_m(make_box({1, 1, 0.001}, 16)), thickness_m(plate), 1e-12);
  EXPECT_NEAR(thickness_m(moved(plate, some_motion())), thickness_m(plate), 1e-12);
  EXPECT_NEAR(thickness_m(scaled(plate, 1e-6)), 1e-6 * thickness_m(plate), 1e-18);
  EXPECT_NEAR(thickness_m(make_sphere(0.006, 4)), 0.004, 2e-5) << "of a ball a third of its diameter";
  TriangleMesh inwards = plate;
  for (Triangle& triangle : inwards.triangles) std::swap(triangle[0], triangle[1]);
  EXPECT_NEAR(thickness_m(inwards), thickness_m(plate), 1e-12);
}

TEST(Thickness, OfASheetIsUnknownAndASmallHoleChangesLittle) {
  TriangleMesh sheet{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  EXPECT_EQ(thickness_m(sheet), 0);
  EXPECT_EQ(thickness_m({}), 0);
  TriangleMesh ball = make_sphere(0.1, 4);
  const double whole_m = thickness_m(ball);
  ball.triangles.resize(ball.triangles.size() - 6);
  EXPECT_NEAR(thickness_m(ball), whole_m, 0.05 * whole_m);
}

TEST(DepthLimit, IsTheSmallestShareOfItsLengths) {
  const MuscleSize fine{"muscle", 0.001, 0.4, 1000};
  EXPECT_DOUBLE_EQ(depth_limit(fine, BoneSize{"bone", 0.02}).depth_m, 0.001);
  EXPECT_EQ(depth_limit(fine, BoneSize{"bone", 0.02}).because, "1 mean edge");
  const MuscleSize coarse{"muscle", 0.02, 0.2, 1000};
  EXPECT_DOUBLE_EQ(depth_limit(coarse, BoneSize{"bone", 0.02}).depth_m, 0.001);
  EXPECT_EQ(depth_limit(coarse, BoneSize{"bone", 0.02}).because, "0.5 % of the muscle's size");
  EXPECT_DOUBLE_EQ(depth_limit(coarse, BoneSize{"needle", 0.0005}).depth_m, 0.000125);
  EXPECT_EQ(depth_limit(coarse, BoneSize{"needle", 0.0005}).because, "25 % of the bone's thickness");
  EXPECT_DOUBLE_EQ(depth_limit(coarse, BoneSize{"sheet", 0}).depth_m, 0.001) << "a thickness that is unknown";
  EXPECT_DOUBLE_EQ(depth_limit(coarse, MuscleSize{"small", 0.02, 0.05, 9}).depth_m, 0.00025);
  EXPECT_TRUE(std::isinf(depth_limit(MuscleSize{}, BoneSize{}).depth_m));
}

TEST(MuscleSizes, AreThoseAtRest) {
  const MuscleSize size = size_of("ball", make_box({0.3, 0.4, 1.2}, 2));
  EXPECT_EQ(size.name, "ball");
  EXPECT_NEAR(size.diagonal_m, 2.6, 1e-12);
  EXPECT_EQ(size.triangles, 48);
}

}  // namespace
}  // namespace musclebench
