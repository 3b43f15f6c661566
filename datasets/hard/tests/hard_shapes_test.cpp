#include "datasets/hard/hard_shapes.hpp"

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_volume.hpp"
#include "core/mesh_repair/check_mesh.hpp"
#include "core/mesh_repair/repair_mesh.hpp"

namespace musclebench {
namespace {

double volume_m3(const TriangleMesh& mesh) { return surface_volume_m3(mesh.vertices, mesh.triangles); }

TEST(HardShapes, AreClosedAndOutward) {
  for (const TriangleMesh& mesh : {make_spike(), make_bumpy_ball(3), make_plate(1e-4), make_winged_block(1e-3)}) {
    EXPECT_TRUE(repair_mesh(mesh, "shape").clean);
    EXPECT_GT(volume_m3(mesh), 0);
  }
  // Of a cone over a regular polygon of 24 sides.
  EXPECT_NEAR(volume_m3(make_spike()), 12 * std::sin(M_PI / 12) * 0.003 * 0.003 * 0.06 / 3, 1e-12);
  EXPECT_NEAR(volume_m3(make_plate(1e-4)), 1e-6, 1e-15);
  EXPECT_NEAR(volume_m3(make_winged_block(1e-3)), 2.08e-4, 1e-15);
}

TEST(HardShapes, AHoleIsAsManyTrianglesAtItsPlace) {
  const TriangleMesh ball = make_sphere(1, 3);
  for (const int triangles : {1, 10, 100}) {
    const TriangleMesh open = with_hole(ball, triangles, Vec3(0, 0, 1));
    ASSERT_EQ(open.triangles.size() + static_cast<std::size_t>(triangles), ball.triangles.size());
    // What is gone lies about the top, and the rest still encloses most of the volume as seen from the centre.
    EXPECT_LT(volume_m3(open), volume_m3(ball));
    EXPECT_GT(volume_m3(open), 0.85 * volume_m3(ball));
  }
}

TEST(HardShapes, BadTrianglesMeanTheSameSurface) {
  const TriangleMesh ball = make_bumpy_ball(3);
  const TriangleMesh bad = with_bad_triangles(ball);
  EXPECT_GT(bad.triangles.size(), ball.triangles.size() + 100);
  const RepairedMesh repaired = repair_mesh(bad, "bad");
  EXPECT_FALSE(repaired.changes.empty());
  EXPECT_NEAR(volume_m3(repaired.mesh), volume_m3(ball), 1e-9 * volume_m3(ball));
}

TEST(HardShapes, InsideOutHasTheOppositeVolume) {
  EXPECT_DOUBLE_EQ(volume_m3(inside_out(make_spike())), -volume_m3(make_spike()));
}

}  // namespace
}  // namespace musclebench
