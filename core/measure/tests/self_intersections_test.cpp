#include "core/measure/self_intersections.hpp"

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

TEST(SelfIntersections, SoundShapesHaveNone) {
  for (const TriangleMesh& mesh : {make_sphere(0.1, 3), make_box({1, 2, 3}, 6), make_capsule(0.1, 0.3, 12)}) {
    EXPECT_EQ(count_self_intersecting_triangles(mesh), 0);
  }
  EXPECT_EQ(count_self_intersecting_triangles({}), 0);
}

TEST(SelfIntersections, BothTrianglesCountOnce) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.3, 0.2, 1}, {5, 5, 5}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {2, 1, 6}};
  EXPECT_EQ(count_self_intersecting_triangles(mesh), 2);
  mesh.triangles.push_back({5, 4, 3});  // the same from behind: it shares three vertices with the second
  EXPECT_EQ(count_self_intersecting_triangles(mesh), 3);
}

TEST(SelfIntersections, NeighboursThatShareAVertexMayFoldThroughEachOther) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.4, 0.2, -1}, {0.2, 0.4, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  EXPECT_EQ(count_self_intersecting_triangles(mesh), 2);
  mesh.vertices[3] = {0.4, 0.2, 0.1};  // on one side
  EXPECT_EQ(count_self_intersecting_triangles(mesh), 0);
}

TEST(SelfIntersections, LikeEveryPairTriedOnAFoldedSheet) {
  // A sphere pushed through itself: its upper cap below its lower one.
  TriangleMesh folded = make_sphere(1, 3);
  for (Vec3& p : folded.vertices) {
    if (p.z() > 0.5) p.z() -= 1.8;
  }
  const int found = count_self_intersecting_triangles(folded);
  EXPECT_GT(found, 20);
  EXPECT_LT(found, 600);
  EXPECT_EQ(count_self_intersecting_triangles(moved(folded, some_motion())), found);
}

}  // namespace
}  // namespace musclebench
