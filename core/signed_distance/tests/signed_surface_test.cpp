#include "core/signed_distance/signed_surface.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/tests/lhdl_data.hpp"
#include "core/mesh_files/read_mesh.hpp"

namespace musclebench {
namespace {

TriangleMesh joined(TriangleMesh mesh, const TriangleMesh& other, const Vec3& offset) {
  const auto first = static_cast<int>(mesh.vertices.size());
  for (const Vec3& vertex : other.vertices) {
    mesh.vertices.emplace_back(vertex + offset);
  }
  for (const Triangle& t : other.triangles) {
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return mesh;
}

TriangleMesh inverted(TriangleMesh mesh) {
  for (Triangle& t : mesh.triangles) {
    std::swap(t[1], t[2]);
  }
  return mesh;
}

/// A box with a doubled triangle that stands on one of its edges.
TriangleMesh box_with_fin() {
  TriangleMesh mesh = make_box(Vec3(1, 1, 1), 6);
  const Triangle& t = mesh.triangles[7];
  int a = t[0];
  int b = t[1];
  const auto tip = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(1.8 * mesh.vertices[static_cast<std::size_t>(a)]);
  mesh.triangles.push_back({a, b, tip});
  mesh.triangles.push_back({b, a, tip});
  return mesh;
}

/// A cone so sharp that all faces about its tip fold onto one another.
TriangleMesh spike(double radius, int sides) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 1}, {0, 0, -1}};
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), -0.9);
  }
  for (int i = 0; i < sides; ++i) {
    mesh.triangles.push_back({0, 2 + i, 2 + (i + 1) % sides});
    mesh.triangles.push_back({1, 2 + (i + 1) % sides, 2 + i});
  }
  return mesh;
}

/// A solid that ends in a blade: its two faces meet in an edge along y through the origin at an angle of 2 `slope`, and
/// its body, behind x = -1, is thick. Every face touches others at common corners only.
TriangleMesh blade(double slope) {
  TriangleMesh mesh;
  mesh.vertices = {{0, -0.5, 0},     {0, 0.5, 0},     {-1, 0, slope},     {-1.2, -0.7, 0.6},
                   {-1.2, 0.7, 0.6}, {-1, 0, -slope}, {-1.2, -0.7, -0.6}, {-1.2, 0.7, -0.6}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}, {2, 4, 3},   // above
                    {1, 0, 5}, {0, 6, 5}, {1, 5, 7}, {5, 6, 7},   // below
                    {0, 3, 6}, {1, 7, 4}, {3, 4, 7}, {3, 7, 6}};  // sides and back
  return mesh;
}

struct Shape {
  std::string name;
  TriangleMesh mesh;
  double least_manifold;  ///< fraction of the features that have to be manifold
  double most_clean;
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name.
void PrintTo(const Shape& shape, std::ostream* out) { *out << shape.name; }

std::vector<Shape> shapes() {
  const TriangleMesh ball = make_sphere(1, 3);
  const TriangleMesh small = make_sphere(0.5, 2);
  const TriangleMesh box = make_box(Vec3(0.5, 0.5, 0.5), 4);
  return {
      {"sphere", ball, 1, 1},
      {"box", make_box(Vec3(1, 0.5, 0.2), 5), 1, 1},
      {"capsule", make_capsule(0.3, 0.9, 24), 1, 1},
      {"spike", spike(0.01, 12), 0, 1},
      {"fin", box_with_fin(), 0.9, 0.999},
      {"hollow", joined(ball, inverted(small), Vec3::Zero()), 1, 1},
      // Inside the small one the winding number is 2, and its own surface does not bound the inside.
      {"ball_in_a_ball", joined(ball, small, Vec3::Zero()), 0.75, 0.85},
      {"inside_out", inverted(ball), 0, 0},
      {"overlap", joined(ball, small, Vec3(0.9, 0.1, 0.05)), 0.5, 0.95},
      {"apart", joined(ball, small, Vec3(3, 0, 0)), 1, 1},
      {"boxes_with_a_common_face", joined(box, box, Vec3(1, 0, 0)), 0.6, 0.9},
      // Two fans about one vertex.
      {"boxes_at_a_point", repair_mesh(joined(box, box, Vec3(1, 1, 1)), "boxes").mesh, 0.99, 0.9999},
      {"boxes_that_nearly_touch", joined(box, box, Vec3(1 + 1e-14, 0.1, 0.05)), 0.4, 0.9},
      {"boxes_with_a_gap", joined(box, box, Vec3(1 + 1e-6, 0.1, 0.05)), 1, 1},
      {"open", {ball.vertices, {ball.triangles.begin() + 3, ball.triangles.end()}}, 0, 0},
  };
}

double manifold_fraction(const TriangleMesh& mesh, const ManifoldFeatures& clean) {
  int count = 0;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    for (int feature = 0; feature < 7; ++feature) {
      count += clean.holds(t, static_cast<Feature>(feature)) ? 1 : 0;
    }
  }
  return count / (7.0 * static_cast<double>(mesh.triangles.size()));
}

/// Points about vertices, edges and faces, at all distances.
std::vector<Vec3> points_about(const TriangleMesh& mesh, const std::vector<int>& triangles, int count, double size) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::uniform_int_distribution<std::size_t> any(0, triangles.size() - 1);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(triangles[any(random)])];
    const auto corner = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    const std::array<Vec3, 3> on = {corner(0), 0.5 * (corner(0) + corner(1)), (corner(0) + corner(1) + corner(2)) / 3};
    const double x = unit(random);
    const double y = unit(random);
    const double distance = size * std::pow(10.0, 4 * unit(random) - 4);
    points.emplace_back(on[static_cast<std::size_t>(i % 3)] + distance * Vec3(x, y, unit(random)));
  }
  return points;
}

class SignedSurfaceShapes : public testing::TestWithParam<Shape> {};

TEST_P(SignedSurfaceShapes, InsideIsWhereTheWindingNumberExceedsAHalf) {
  const TriangleMesh& mesh = GetParam().mesh;
  const SignedSurface surface({mesh, false, {}});
  std::vector<int> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  int inside = 0;
  for (const Vec3& point : points_about(mesh, all, 2000, 1)) {
    const SignedPoint found = surface.locate(point);
    const bool expected = found.closest.distance_m > 0 && surface.tree().winding_number(point) > 0.5;
    EXPECT_EQ(found.inside, expected) << point.transpose() << " at " << found.closest.distance_m;
    EXPECT_EQ(surface.locate_inside(point).has_value(), expected);
    inside += expected ? 1 : 0;
  }
  EXPECT_EQ(inside > 0, GetParam().name != "inside_out");
}

TEST_P(SignedSurfaceShapes, FeaturesAreManifoldWhereNothingTouchesThem) {
  const Shape& shape = GetParam();
  if (shape.name == "open") {
    return;  // There the question makes no sense.
  }
  const double share =
      manifold_fraction(shape.mesh, ManifoldFeatures(shape.mesh, TriangleBvh(shape.mesh), MeshEdges(shape.mesh)));
  EXPECT_GE(share, shape.least_manifold);
  EXPECT_LE(share, shape.most_clean);
}

INSTANTIATE_TEST_SUITE_P(All, SignedSurfaceShapes, testing::ValuesIn(shapes()),
                         [](const auto& shape) { return shape.param.name; });

TEST(SignedSurface, OfThePelvisWithItsFinHasNoWrongSign) {
  const auto folder = lhdl_folder();
  if (!folder) {
    GTEST_SKIP() << "needs the LHDL data";
  }
  const RepairedMesh pelvis = repair_mesh(read_mesh(*folder / "meshes" / "pelvis.ply"), "pelvis");
  ASSERT_FALSE(pelvis.clean);
  const SignedSurface surface(pelvis);
  const ManifoldFeatures clean(pelvis.mesh, surface.tree(), MeshEdges(pelvis.mesh));
  std::vector<int> unclean;
  for (int t = 0; t < static_cast<int>(pelvis.mesh.triangles.size()); ++t) {
    if (!clean.holds(t, Feature::corner_0) || !clean.holds(t, Feature::corner_1) || !clean.holds(t, Feature::face)) {
      unclean.push_back(t);
    }
  }
  EXPECT_FALSE(unclean.empty());
  EXPECT_LT(static_cast<double>(unclean.size()), 0.01 * static_cast<double>(pelvis.mesh.triangles.size()));
  int by_normal = 0;
  int wrong = 0;
  for (const Vec3& point : points_about(pelvis.mesh, unclean, 20000, 0.05)) {
    const SignedPoint found = surface.locate(point);
    by_normal += clean.holds(found.closest.triangle, found.closest.feature) ? 1 : 0;
    const bool expected = found.closest.distance_m > 0 && surface.tree().winding_number(point) > 0.5;
    wrong += found.inside != expected ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(by_normal, 2000);
}

/// Beside a blade the pseudo-normal of its edge is perpendicular to the displacement but for the blade's angle, and of
/// the normal's own size, which is that angle, rounding is a far larger share.
TEST(SignedSurface, BesideABladeRoundingDoesNotTellTheSide) {
  constexpr double slope = 4e-9;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  int at_the_edge = 0;
  int inside = 0;
  for (int turn = 0; turn < 200; ++turn) {
    const double x = any(random);
    const double y = any(random);
    const double z = any(random);
    const Mat3 rotation = Eigen::Quaterniond(any(random), x, y, z).normalized().toRotationMatrix();
    TriangleMesh mesh = blade(slope);
    for (Vec3& vertex : mesh.vertices) vertex = rotation * vertex;
    const SignedSurface surface({mesh, true, {}});
    const ManifoldFeatures manifold(mesh, surface.tree(), MeshEdges(mesh));
    for (const double side : {-1.0, 1.0}) {
      for (const double over : {2.0, 5.0, 20.0}) {
        const SignedPoint found = surface.locate(rotation * Vec3(over * slope, 0.1, side));
        at_the_edge +=
            found.closest.feature != Feature::face && manifold.holds(found.closest.triangle, found.closest.feature);
        inside += found.inside;
      }
    }
  }
  EXPECT_GT(at_the_edge, 600);
  EXPECT_EQ(inside, 0);
}

}  // namespace
}  // namespace musclebench
