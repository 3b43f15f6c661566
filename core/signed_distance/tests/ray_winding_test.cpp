#include "core/signed_distance/ray_winding.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/bvh/triangle_bvh.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

void add(TriangleMesh& mesh, const TriangleMesh& other, const Vec3& by_m, bool inwards = false) {
  const auto first = static_cast<int>(mesh.vertices.size());
  for (const Vec3& vertex : other.vertices) mesh.vertices.push_back(vertex + by_m);
  for (const auto& [a, b, c] : other.triangles) {
    mesh.triangles.push_back(inwards ? Triangle{first + a, first + c, first + b}
                                     : Triangle{first + a, first + b, first + c});
  }
}

std::vector<Vec3> points_in(const Eigen::AlignedBox3d& box, int count) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = share(random);
    const double y = share(random);
    points.push_back(box.min() + Vec3(x, y, share(random)).cwiseProduct(box.sizes()));
  }
  return points;
}

/// Two balls that overlap, and a third with a cavity.
TriangleMesh balls() {
  TriangleMesh mesh = make_sphere(0.1, 3);
  add(mesh, make_sphere(0.08, 3), Vec3(0.12, 0.01, 0));
  add(mesh, make_sphere(0.1, 3), Vec3(-0.3, 0, 0));
  add(mesh, make_sphere(0.05, 3), Vec3(-0.3, 0, 0), true);
  return mesh;
}

TEST(RayWinding, IsTheWindingNumberWhereverTheBoxLies) {
  const TriangleMesh mesh = balls();
  const TriangleBvh tree(mesh);
  // At each end of each axis, so that every direction is once the shortest way out, and over all of it.
  std::vector<Eigen::AlignedBox3d> boxes = {{Vec3(-0.45, -0.15, -0.15), Vec3(0.25, 0.15, 0.15)}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Vec3 centre = 0.09 * sign * Vec3::Unit(axis);
      boxes.emplace_back(centre - Vec3::Constant(0.03), centre + Vec3::Constant(0.03));
    }
  }
  for (const Eigen::AlignedBox3d& box : boxes) {
    const RayWinding rays(mesh, box);
    int inside = 0;
    for (const Vec3& point : points_in(box, 2000)) {
      const auto winding = rays.at(point);
      ASSERT_TRUE(winding) << point.transpose();
      EXPECT_EQ(*winding, std::lround(tree.winding_number(point))) << point.transpose();
      inside += *winding > 0 ? 1 : 0;
    }
    EXPECT_GT(inside, 100);
  }
}

/// Rays through edges and corners, and in the planes of faces.
TEST(RayWinding, CountsARayThroughAnEdgeOnce) {
  const TriangleMesh mesh = make_box(Vec3(1, 1, 1), 4);
  const Eigen::AlignedBox3d box(Vec3(-2, -2, -2), Vec3(2, 2, 2));
  const RayWinding rays(mesh, box);
  int told = 0;
  for (int i = 0; i < 9 * 9 * 9; ++i) {
    const Vec3 point(-2 + 0.5 * (i % 9), -2 + 0.5 * (i / 9 % 9), -2 + 0.5 * (i / 81));
    const double outermost = point.cwiseAbs().maxCoeff();
    const auto winding = rays.at(point);
    if (winding && outermost != 1) {
      ++told;
      EXPECT_EQ(*winding, outermost < 1 ? 1 : 0) << point.transpose();
    }
    if (outermost < 1) {
      EXPECT_TRUE(winding) << point.transpose();
    }
  }
  EXPECT_GT(told, 500);
}

TEST(RayWinding, LeavesAPointOnTheSurfaceOpen) {
  const TriangleMesh mesh = make_box(Vec3(1, 1, 1), 20);  // rays upwards meet the fewest of its vertices
  const Vec3 point(0.33, 0.21, 1);
  const RayWinding rays(mesh, {point - Vec3(0.1, 0.1, 0), point + Vec3(0.1, 0.1, 0.5)});
  EXPECT_FALSE(rays.at(point));
  EXPECT_EQ(rays.at(point + Vec3(0, 0, 0.1)), 0);
}

}  // namespace
}  // namespace musclebench
