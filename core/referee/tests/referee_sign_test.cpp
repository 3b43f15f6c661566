#include "core/referee/referee_sign.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

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

__extension__ using Wide = __int128;

/// Of whole numbers that doubles hold and 128 bits can multiply.
int side_in_integers(const std::array<std::array<std::int64_t, 3>, 4>& points) {
  std::array<std::array<Wide, 3>, 3> from{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) from[i][axis] = Wide{points[i][axis]} - points[3][axis];
  }
  Wide determinant = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    determinant += from[0][i] * (from[1][j] * from[2][k] - from[1][k] * from[2][j]);
  }
  return determinant > 0 ? -1 : determinant < 0 ? 1 : 0;
}

/// On a plane, beside it by the last bit of a coordinate, and anywhere.
TEST(PlaneSide, IsThatOfExactArithmetic) {
  std::mt19937_64 random(5);
  std::array<int, 3> seen{};
  for (int sample = 0; sample < 100'000; ++sample) {
    std::uniform_int_distribution<std::int64_t> coordinate(-(std::int64_t{1} << 36), std::int64_t{1} << 36);
    std::uniform_int_distribution<std::int64_t> share(-3, 3);
    std::array<std::array<std::int64_t, 3>, 4> points{};
    const std::int64_t along_b = share(random);
    const std::int64_t along_c = share(random);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < 3; ++i) points[i][axis] = coordinate(random);
      points[3][axis] = points[0][axis] + along_b * (points[1][axis] - points[0][axis]) +
                        along_c * (points[2][axis] - points[0][axis]);
    }
    if (sample % 3 > 0) points[3][sample % 3] += sample % 2 == 0 ? 1 : -1;
    std::array<Vec3, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) {
      corners[i] = Vec3(static_cast<double>(points[i][0]), static_cast<double>(points[i][1]),
                        static_cast<double>(points[i][2])) *
                   0x1p-50;
    }
    const int wanted = side_in_integers(points);
    ASSERT_EQ(plane_side(corners[0], corners[1], corners[2], corners[3]), wanted) << sample;
    ++seen[static_cast<std::size_t>(wanted + 1)];
  }
  for (const int count : seen) EXPECT_GT(count, 10'000);
}

/// Coordinates whose differences are not doubles: whichever of the four points is looked from, the answer is the same.
TEST(PlaneSide, DoesNotDependOnThePointItIsSeenFrom) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] { return Vec3(uniform(random), 1e-3 * uniform(random), 1e3 * uniform(random)); };
  int decided_late = 0;
  for (int sample = 0; sample < 100'000; ++sample) {
    const Vec3 a = point();
    const Vec3 b = point();
    const Vec3 c = point();
    const Vec3 p = a + uniform(random) * (b - a) + uniform(random) * (c - a);
    const int side = plane_side(a, b, c, p);
    ASSERT_EQ(plane_side(b, a, c, p), -side);
    ASSERT_EQ(plane_side(p, b, c, a), -side);
    ASSERT_EQ(plane_side(a, p, c, b), -side);
    ASSERT_EQ(plane_side(a, b, p, c), -side);
    decided_late += side != 0 ? 1 : 0;
  }
  EXPECT_GT(decided_late, 90'000);
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

/// Of points on a grid of 2^-grid: the sign of det(b - a, c - a, d - a) in whole numbers, and so without rounding.
int side_in_integers(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, int grid) {
  std::array<std::array<Wide, 3>, 3> m;
  const std::array<const Vec3*, 3> ends{&b, &c, &d};
  for (std::size_t row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis) {
      m[row][static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(std::ldexp((*ends[row])[axis], grid)) -
                                               static_cast<std::int64_t>(std::ldexp(a[axis], grid));
    }
  }
  const Wide det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                   m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                   m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  return (det > 0) - (det < 0);
}

bool passes_in_integers(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& from, const Vec3& to, int grid) {
  const int sides = side_in_integers(a, b, c, from, grid) * side_in_integers(a, b, c, to, grid);
  const int ab = side_in_integers(from, to, a, b, grid);
  return sides < 0 && ab != 0 && side_in_integers(from, to, b, c, grid) == ab &&
         side_in_integers(from, to, c, a, grid) == ab;
}

bool pass_through_by_edges(const TriangleCorners& one, const TriangleCorners& other, int grid) {
  const auto an_edge_passes = [grid](const TriangleCorners& edges, const TriangleCorners& face) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (passes_in_integers(face[0], face[1], face[2], edges[k], edges[(k + 1) % 3], grid)) return true;
    }
    return false;
  };
  return an_edge_passes(one, other) || an_edge_passes(other, one);
}

/// Corners that lie on the other's plane or one step of a grid beside it: floating point alone gets thousands of their
/// sides wrong.
TEST(PassThroughEachOther, IsExactWhereItIsNearlyDegenerate) {
  constexpr int grid = 40, eighths = grid - 3;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  std::uniform_int_distribution<int> eighth(0, 8), step(-1, 1);
  const auto point = [&] {
    return Vec3(Vec3(unit(random), unit(random), unit(random)).unaryExpr([](double x) {
      return std::ldexp(std::nearbyint(std::ldexp(x, eighths)), -eighths);
    }));
  };
  int passing = 0, plain_is_wrong = 0;
  for (int i = 0; i < 20000; ++i) {
    const TriangleCorners face{point(), point(), point()};
    const Vec3 &a = face[0], &b = face[1], &c = face[2];  // clang 14 captures no structured bindings
    const auto near = [&] {
      const int u = eighth(random);
      const Vec3 on_plane = a + u / 8.0 * (b - a) + std::min(eighth(random), 8 - u) / 8.0 * (c - a);
      return Vec3(on_plane + std::ldexp(1, -grid) * Vec3(step(random), i % 2 == 0 ? step(random) : 0, 0));
    };
    const TriangleCorners other{near(), i % 3 == 0 ? near() : point(), point()};
    if ((other[1] - other[0]).cross(other[2] - other[0]).isZero(0)) continue;  // without an inside
    const bool passes = pass_through_each_other(face, other);
    EXPECT_EQ(passes, pass_through_by_edges(face, other, grid)) << i;
    EXPECT_EQ(pass_through_each_other({other[1], other[0], other[2]}, {c, a, b}), passes) << i;
    EXPECT_EQ(plane_side(a, b, c, other[0]), side_in_integers(a, b, c, other[0], grid)) << i;
    passing += passes ? 1 : 0;
    const double plain = (b - a).cross(c - a).dot(other[0] - a);
    plain_is_wrong += (plain > 0) - (plain < 0) != side_in_integers(a, b, c, other[0], grid) ? 1 : 0;
  }
  EXPECT_GT(passing, 2000);
  EXPECT_GT(plain_is_wrong, 1000) << "nothing here is hard";
}

/// Of corners with small whole coordinates, by the two parts of the line that the planes share, as fractions.
bool pass_through_in_fractions(const TriangleCorners& one, const TriangleCorners& other) {
  const auto normal_of = [](const TriangleCorners& t) { return Vec3((t[1] - t[0]).cross(t[2] - t[0])); };
  const Vec3 along = normal_of(one).cross(normal_of(other));
  struct Part {
    double low = 1e9, high = -1e9;  // times a common denominator that whole numbers of this size keep exact
    bool both_sides = false;
  };
  // Heights and coordinates are whole numbers below 2^12, so fractions of them differ by 2^-24 where they differ.
  const auto part_of = [&](const TriangleCorners& t, const TriangleCorners& plane) {
    Part part;
    std::array<double, 3> height;
    for (std::size_t k = 0; k < 3; ++k) height[k] = normal_of(plane).dot(t[k] - plane[0]);
    part.both_sides = *std::ranges::min_element(height) < 0 && *std::ranges::max_element(height) > 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      if (height[k] * height[next] > 0 || height[k] == height[next]) continue;
      const double at = (along.dot(t[k]) * height[next] - along.dot(t[next]) * height[k]) / (height[next] - height[k]);
      part.low = std::min(part.low, at);
      part.high = std::max(part.high, at);
    }
    return part;
  };
  const Part a = part_of(one, other), b = part_of(other, one);
  return a.both_sides && b.both_sides && std::max(a.low, b.low) + 1e-6 < std::min(a.high, b.high);
}

/// Corners on a small grid: every kind of touching comes up, and triangles that meet in the same part of a line.
TEST(PassThroughEachOther, WhatTouchesDoesNotPass) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> coordinate(0, 3);
  const auto point = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  int passing = 0, by_no_edge = 0;
  for (int i = 0; i < 50000; ++i) {
    const TriangleCorners one{point(), point(), point()};
    TriangleCorners other{point(), point(), point()};
    if (i % 4 == 0) other[0] = one[2];
    const auto has_area = [](const TriangleCorners& t) { return !(t[1] - t[0]).cross(t[2] - t[0]).isZero(0); };
    if (!has_area(one) || !has_area(other)) continue;  // without an inside
    const bool passes = pass_through_each_other(one, other);
    EXPECT_EQ(passes, pass_through_in_fractions(one, other)) << i;
    passing += passes ? 1 : 0;
    const bool an_edge_passes = pass_through_by_edges(one, other, 0);
    by_no_edge += passes && !an_edge_passes ? 1 : 0;
    EXPECT_LE(an_edge_passes, passes) << i;
  }
  EXPECT_GT(passing, 500);
  EXPECT_GT(by_no_edge, 50) << "where both meet in the same part of a line, edges meet edges only";
}

}  // namespace
}  // namespace musclebench
