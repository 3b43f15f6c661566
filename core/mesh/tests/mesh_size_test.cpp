#include "core/mesh/mesh_size.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

TEST(MeshSize, OfABoxIsThatOfItsFaces) {
  const TriangleMesh box = make_box({0.1, 0.2, 0.3}, 3);
  const Vec3 sizes = bounding_box(box.vertices).sizes();
  const double area_m2 = 2 * (sizes[0] * sizes[1] + sizes[1] * sizes[2] + sizes[2] * sizes[0]);
  EXPECT_NEAR(surface_area_m2(box), area_m2, 1e-14);
  EXPECT_NEAR(mean_triangle_size_m(box), std::sqrt(area_m2 / static_cast<double>(box.triangles.size())), 1e-14);
}

TEST(MeshSize, OfNothingIsNothing) {
  EXPECT_EQ(surface_area_m2({}), 0);
  EXPECT_EQ(mean_triangle_size_m({}), 0);
}

}  // namespace
}  // namespace musclebench
