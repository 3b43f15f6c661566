#include "core/referee/referee_sign.hpp"

#include <gtest/gtest.h>

namespace musclebench {
namespace {

constexpr AxisRay up{2, true};
constexpr AxisRay down{2, false};

TEST(RayCrossing, LeavesAndEnters) {
  const Vec3 a(0, 0, 1);
  const Vec3 b(1, 0, 1);
  const Vec3 c(0, 1, 1);
  const Vec3 below(0.25, 0.25, 0);
  const Vec3 above(0.25, 0.25, 2);
  EXPECT_EQ(ray_crossing(a, b, c, below, up), 1) << "through the front";
  EXPECT_EQ(ray_crossing(a, c, b, below, up), -1) << "through the back";
  EXPECT_EQ(ray_crossing(a, b, c, below, down), 0) << "behind the start";
  EXPECT_EQ(ray_crossing(a, b, c, above, up), 0);
  EXPECT_EQ(ray_crossing(a, b, c, above, down), -1);
  EXPECT_EQ(ray_crossing(a, c, b, above, down), 1);
  EXPECT_EQ(ray_crossing(a, b, c, Vec3(0.75, 0.75, 0), up), 0) << "beside it";
}

TEST(RayCrossing, EveryAxis) {
  const Vec3 a(0, 0, 1);
  const Vec3 b(1, 0, 1);
  const Vec3 c(0, 1, 1);
  const Vec3 start(0.25, 0.25, 0);
  const auto turn = [](const Vec3& v, int times) {
    Vec3 turned;
    for (int i = 0; i < 3; ++i) turned[(i + times) % 3] = v[i];
    return turned;
  };
  for (int times = 0; times < 3; ++times) {
    const AxisRay ray{(2 + times) % 3, true};
    EXPECT_EQ(ray_crossing(turn(a, times), turn(b, times), turn(c, times), turn(start, times), ray), 1);
  }
}

TEST(RayCrossing, DecidesTheSideOfAnEdgeExactly) {
  // Half a unit in the last place beside the diagonal: the plain determinant is 0 or of either sign.
  const Vec3 a(0, 0, 1);
  const Vec3 b(1, 1, 1);
  const Vec3 left(0, 1, 1);
  const Vec3 right(1, 0, 1);
  const double step = 0x1p-53;
  EXPECT_EQ(ray_crossing(a, b, left, Vec3(0.5, 0.5 + step, 0), up), 1);
  EXPECT_EQ(ray_crossing(a, right, b, Vec3(0.5, 0.5 + step, 0), up), 0);
  EXPECT_EQ(ray_crossing(a, b, left, Vec3(0.5 + step, 0.5, 0), up), 0);
  EXPECT_EQ(ray_crossing(a, right, b, Vec3(0.5 + step, 0.5, 0), up), 1);
  const int crossings =
      ray_crossing(a, b, left, Vec3(0.5, 0.5, 0), up) + ray_crossing(a, right, b, Vec3(0.5, 0.5, 0), up);
  EXPECT_EQ(crossings, 1) << "on the edge exactly one of its triangles is met";
}

TEST(RayCrossing, DecidesTheSideOfThePlaneExactly) {
  // With edges (k, 4, 0) and (0, k, 4) the normal is (16, -4 k, k^2): a small step along x changes the determinant by
  // next to nothing beside its terms of the size k^3.
  const double k = 0x1p19;
  const Vec3 a(k + 3, k + 5, k + 7);
  const Vec3 b = a + Vec3(k, 4, 0);
  const Vec3 c = a + Vec3(0, k, 4);
  const Vec3 on_plane = a + 0.25 * Vec3(k, k + 4, 4);
  for (const double step : {1.0, 0x1p-4, 0x1p-20}) {
    const Vec3 front = on_plane + Vec3(step, 0, 0);
    const Vec3 behind = on_plane - Vec3(step, 0, 0);
    EXPECT_EQ(ray_crossing(a, b, c, front, up), 0) << step;
    EXPECT_EQ(ray_crossing(a, b, c, front, down), -1) << step;
    EXPECT_EQ(ray_crossing(a, b, c, behind, up), 1) << step;
    EXPECT_EQ(ray_crossing(a, b, c, behind, down), 0) << step;
  }
}

TEST(RayCrossing, TrianglesSeenEdgeOnAreMissed) {
  const Vec3 start(0, 0, 0);
  EXPECT_EQ(ray_crossing(Vec3(-1, 0, 1), Vec3(1, 0, 1), Vec3(0, 0, 3), start, up), 0);
  EXPECT_EQ(ray_crossing(Vec3(0, 0, 1), Vec3(0, 0, 2), Vec3(0, 1, 1), start, up), 0);
  EXPECT_EQ(ray_crossing(Vec3(0, 0, 1), Vec3(0, 0, 1), Vec3(0, 0, 1), start, up), 0);
}

/// Winding number of a lone triangle: its crossing and the strips of its three sides.
double winding_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& eye, AxisRay ray) {
  return ray_crossing(a, b, c, eye, ray) + strip_share(a, b, eye, ray) + strip_share(b, c, eye, ray) +
         strip_share(c, a, eye, ray);
}

constexpr AxisRay all_rays[] = {{0, true}, {0, false}, {1, true}, {1, false}, {2, true}, {2, false}};

TEST(StripShare, OctantIsAnEighthAlongEveryRay) {
  for (const AxisRay ray : all_rays) {
    EXPECT_NEAR(winding_of(Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3::Zero(), ray), 0.125, 1e-15);
    EXPECT_NEAR(winding_of(Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3::Zero(), ray), -0.125, 1e-15);
  }
}

TEST(StripShare, CloseToAFaceItIsAHalf) {
  const Vec3 eye(0.3, 0.3, -1e-12);
  for (const AxisRay ray : all_rays) {
    EXPECT_NEAR(winding_of(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), eye, ray), 0.5, 1e-11);
  }
}

TEST(StripShare, NothingJumpsWhereTheRayMeetsABoundaryEdge) {
  // Eyes below and on the sides of the triangle, along the plane through an edge and the ray, within rounding of it.
  const Vec3 a(0, 0, 0);
  const Vec3 b(1, 0.1, 0.2);
  const Vec3 c(0.3, 1, -0.1);
  const double tiny = std::numeric_limits<double>::epsilon();
  for (const double share : {0.0, 0.25, 1.0 / 3, 0.7, 1.0}) {
    for (const double depth : {0.5, 0.01, -0.01}) {
      const Vec3 on = a + share * (b - a) - Vec3(0, 0, depth);
      const double expected = winding_of(a, b, c, on, {0, true});
      for (const double x : {-tiny, 0.0, tiny}) {
        for (const double y : {-tiny, 0.0, tiny}) {
          EXPECT_NEAR(winding_of(a, b, c, on + Vec3(x, y, 0), {2, true}), expected, 1e-12);
          EXPECT_NEAR(winding_of(a, b, c, on + Vec3(x, y, 0), {2, false}), expected, 1e-12);
        }
      }
    }
  }
}

/// Seen from either of its triangles, the edge belongs to one of them, whichever way each of them goes along it.
TEST(SegmentCrossing, ThroughASharedEdgeThereIsOne) {
  const Vec3 a(0, 0, 0);
  const Vec3 b(1, 1, 0);
  const Vec3 left(0, 1, 0);
  const Vec3 right(1, 0, 0);
  const Vec3 from(0.5, 0.5, 1);
  const Vec3 to(0.5, 0.5, -1);
  EXPECT_EQ(segment_crossing(a, b, left, from, to) + segment_crossing(b, a, right, from, to), -1);
  EXPECT_EQ(segment_crossing(a, b, left, to, from) + segment_crossing(b, a, right, to, from), 1);
}

}  // namespace
}  // namespace musclebench
