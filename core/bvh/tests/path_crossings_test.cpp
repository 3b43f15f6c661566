#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/bvh/tests/exact_answers.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// Counted with its sign, a path passes as often through a closed surface as the side changes.
TEST(PathCrossings, TellWhetherAPathChangesSides) {
  for (const TriangleMesh& mesh : {make_sphere(1, 4), make_capsule(0.5, 0.7, 24), make_box({0.3, 1, 0.6}, 7)}) {
    const TriangleBvh tree(mesh);
    std::vector<PathCrossing> crossings;
    const std::vector<Vec3> points = random_points(1.2, 4000);
    int changes = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {
      tree.find_crossings(points[i - 1], points[i], crossings);
      int layers = static_cast<int>(std::lround(exact_winding(mesh, points[i - 1])));
      double last = 0;
      for (const PathCrossing& crossing : crossings) {
        EXPECT_EQ(crossing.entering, layers == 0);  // none of these meshes has layers
        layers += crossing.entering ? 1 : -1;
        EXPECT_GE(crossing.share, last);
        EXPECT_LE(crossing.share, 1);
        last = crossing.share;
        const Vec3 at = points[i - 1] + crossing.share * (points[i] - points[i - 1]);
        EXPECT_LT(closest_on(mesh, crossing.triangle, at).squared_distance_m2, 1e-28);
      }
      EXPECT_EQ(layers, std::lround(exact_winding(mesh, points[i])));
      changes += static_cast<int>(crossings.size());
    }
    EXPECT_GT(changes, 500);
  }
}

/// Neither none nor two where triangles meet.
TEST(PathCrossings, ThroughAnEdgeOrACornerThereIsOne) {
  const TriangleMesh mesh = make_box({1, 1, 1}, 4);  // its corners are at multiples of a half
  const TriangleBvh tree(mesh);
  std::vector<PathCrossing> crossings;
  for (const double x : {-0.5, 0.0, 0.25, 0.5}) {
    for (const double y : {-0.5, 0.0, 0.25, 0.5}) {
      for (const auto& [from, to] :
           {std::pair(Vec3(x, y, 3), Vec3(x, y, 0.1)), std::pair(Vec3(3, x, y), Vec3(0.1, x, y)),
            std::pair(Vec3(x + 2, y - 2, 3), Vec3(x - 0.5, y + 0.5, 0.5))}) {
        tree.find_crossings(from, to, crossings);
        ASSERT_EQ(crossings.size(), 1U) << x << " " << y;
        EXPECT_TRUE(crossings[0].entering);
        tree.find_crossings(to, from, crossings);
        ASSERT_EQ(crossings.size(), 1U) << x << " " << y;
        EXPECT_FALSE(crossings[0].entering);
      }
    }
  }
}

/// One that reached the places of unused slots overran the stack of the search.
TEST(PathCrossings, APathMayBeOfAnyLength) {
  const TriangleBvh tree(make_sphere(1, 2));
  std::vector<PathCrossing> crossings;
  for (const double length : {1e6, 1e19, 1e30, 1e60, 1e300}) {
    tree.find_crossings({0.01, 0.02, 0.03}, {length, 0.9 * length, -0.8 * length}, crossings);
    EXPECT_EQ(crossings.size(), 1U) << length;
    tree.find_crossings({-length, -length, -length}, {length, length, length}, crossings);
    EXPECT_LE(crossings.size(), 4U) << length;
  }
}

TEST(PathCrossings, OfAPathWithoutLengthOrEndThereAreNone) {
  const TriangleBvh tree(make_box({1, 1, 1}, 2));
  std::vector<PathCrossing> crossings(1);
  tree.find_crossings({1, 0, 0}, {1, 0, 0}, crossings);
  EXPECT_TRUE(crossings.empty());
  crossings.resize(1);
  tree.find_crossings({0, 0, 0}, {std::nan(""), 0, 0}, crossings);
  EXPECT_TRUE(crossings.empty());
  tree.find_crossings({0, 0, 0}, {0, 1e30, 0}, crossings);
  EXPECT_EQ(crossings.size(), 1U);
  TriangleBvh((TriangleMesh())).find_crossings({0, 0, 0}, {1, 0, 0}, crossings);
  EXPECT_TRUE(crossings.empty());
}

}  // namespace
}  // namespace musclebench
