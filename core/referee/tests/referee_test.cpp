#include "core/referee/referee.hpp"

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"
#include "core/referee/tests/naive_truth.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

Referee referee_of(const TriangleMesh& mesh) {
  const std::vector<Bone> bones{bone_of(mesh)};
  return Referee(bones, 0);
}

/// Size and sign agree with the plain sums, but for rounding: 1e-12 of the diagonal.
void expect_exact(const TriangleMesh& mesh, const std::vector<Vec3>& points) {
  const Referee referee = referee_of(mesh);
  const double tolerance = 1e-12 * naive::diagonal(mesh);
  for (const Vec3& point : points) {
    const SurfaceDistance found = referee.closest(0, point);
    const double size = naive::distance(mesh, point);
    ASSERT_NEAR(std::abs(found.signed_distance_m), size, tolerance) << point.transpose();
    if (size > tolerance) {
      const bool inside = naive::winding_number(mesh, point) > 0.5;
      ASSERT_EQ(found.signed_distance_m < 0, inside) << point.transpose() << " at " << size;
      const Vec3 to_surface = found.closest_point_m - point;
      // Far from the origin the coordinates of the closest point are rounded themselves.
      const double rounding = tolerance + 1e-15 * point.norm();
      ASSERT_NEAR(to_surface.norm(), size, rounding);
      ASSERT_NEAR((inside ? 1 : -1) * to_surface.dot(found.normal), size, rounding + 1e-9 * size);
    }
    ASSERT_NEAR(found.normal.norm(), 1, 1e-12);
  }
}

void expect_exact_everywhere(const TriangleMesh& mesh, int random_points, unsigned seed) {
  std::mt19937_64 random(seed);
  expect_exact(mesh, naive::cloud(mesh, random_points, random));
  expect_exact(mesh, naive::near_surface(mesh, random_points, 0.01 * naive::diagonal(mesh), random));
  expect_exact(mesh, naive::near_surface(mesh, random_points, 1e-7 * naive::diagonal(mesh), random));
  expect_exact(mesh, mesh.vertices);
  expect_exact(mesh, naive::edge_midpoints(mesh));
}

double distance_to_box(const Vec3& point, const Vec3& half_extents) {
  const Vec3 beyond = point.cwiseAbs() - half_extents;
  return beyond.maxCoeff() <= 0 ? beyond.maxCoeff() : beyond.cwiseMax(0.0).norm();
}

double distance_to_capsule(const Vec3& point, double radius, double half_length) {
  const double z = std::clamp(point.z(), -half_length, half_length);
  return (point - Vec3(0, 0, z)).norm() - radius;
}

TEST(Referee, BoxIsExact) {
  const Vec3 half_extents(0.03, 0.05, 0.11);
  const TriangleMesh box = make_box(half_extents, 6);
  const Referee referee = referee_of(box);
  std::mt19937_64 random(1);
  for (const Vec3& point : naive::cloud(box, 20000, random)) {
    ASSERT_NEAR(referee.signed_distance(0, point), distance_to_box(point, half_extents), 1e-15);
  }
}

TEST(Referee, SphereIsExactWithinItsSagitta) {
  const double radius = 0.04;
  const TriangleMesh sphere = make_sphere(radius, 5);
  double longest = 0;
  for (const Triangle& t : sphere.triangles) {
    const Vec3& a = sphere.vertices[static_cast<std::size_t>(t[0])];
    const Vec3& b = sphere.vertices[static_cast<std::size_t>(t[1])];
    longest = std::max(longest, (a - b).norm());
  }
  // No point of a triangle with vertices on the sphere is farther below it than longest^2 / 3 by the radius.
  const double sagitta = longest * longest / (3 * radius);
  const Referee referee = referee_of(sphere);
  std::mt19937_64 random(2);
  for (const Vec3& point : naive::cloud(sphere, 20000, random)) {
    const double error = referee.signed_distance(0, point) - (point.norm() - radius);
    ASSERT_GT(error, -1e-15);
    ASSERT_LT(error, sagitta);
  }
}

TEST(Referee, CapsuleIsExactWithinItsSagitta) {
  const double radius = 0.02;
  const double half_length = 0.05;
  const TriangleMesh capsule = make_capsule(radius, half_length, 96);
  const double step = 2 * std::numbers::pi * radius / 96;
  const double sagitta = step * step / radius;
  const Referee referee = referee_of(capsule);
  std::mt19937_64 random(3);
  for (const Vec3& point : naive::cloud(capsule, 20000, random)) {
    const double error = referee.signed_distance(0, point) - distance_to_capsule(point, radius, half_length);
    ASSERT_GT(error, -1e-15);
    ASSERT_LT(error, sagitta);
  }
}

TEST(Referee, AgreesWithAllTriangles) {
  expect_exact_everywhere(make_sphere(0.1, 3), 400, 4);
  expect_exact_everywhere(make_box(Vec3(0.1, 0.2, 0.05), 4), 400, 5);
  expect_exact_everywhere(make_capsule(0.02, 0.1, 24), 400, 6);
  expect_exact_everywhere(make_sphere(0.1, 0), 400, 7);
}

TEST(Referee, AgreesWithAllTrianglesOnThinTriangles) {
  TriangleMesh sliver = make_sphere(1, 3);
  for (Vec3& vertex : sliver.vertices) vertex = Vec3(vertex.x(), 1e-4 * vertex.y(), 1e-7 * vertex.z());
  const RigidMotion turn = RigidMotion::about_axis(Vec3(1, 2, 3).normalized(), Vec3::Zero(), 0.7);
  expect_exact_everywhere(moved(sliver, turn), 300, 8);
}

TEST(Referee, SingleNeedlesAreExactOverTheirFaces) {
  const RigidMotion turn = RigidMotion::about_axis(Vec3(1, 2, 3).normalized(), Vec3::Zero(), 0.7);
  std::mt19937_64 random(16);
  std::uniform_real_distribution<double> share(0, 1);
  // Thinner than 2^-28 the plain sum loses its digits before the referee does.
  for (double height = 0x1p-4; height > 0x1p-28; height /= 2) {
    const TriangleMesh sliver = moved({{{0, 0, 0}, {1, 0, 0}, {0.4, height, 0}}, {{0, 1, 2}, {2, 1, 0}}}, turn);
    const Referee referee = referee_of(sliver);
    for (int i = 0; i < 200; ++i) {
      const double along = share(random);
      const double across = share(random) * (1 - along);
      const double above = i % 2 == 0 ? height * share(random) : 1e-3 * share(random);
      const Vec3 flat(along + 0.4 * across, across * height, above);
      const Vec3 point = turn.apply(flat);
      ASSERT_NEAR(referee.signed_distance(0, point), naive::distance(sliver, point), 1e-12) << height << " high";
    }
  }
}

TEST(Referee, RaysThroughVerticesAndEdgesCountOnce) {
  // Every query lies on the box's lattice, so that its ray meets edges and vertices whatever its direction.
  const Vec3 half_extents(4, 4, 4);
  const Referee referee = referee_of(make_box(half_extents, 8));
  for (int x = -6; x <= 6; ++x) {
    for (int y = -6; y <= 6; ++y) {
      for (int z = -6; z <= 6; ++z) {
        const Vec3 point(x, y, z);
        ASSERT_EQ(referee.signed_distance(0, point), distance_to_box(point, half_extents)) << point.transpose();
      }
    }
  }
}

TEST(Referee, OctahedronsOnALatticeAgreeWithTheirFormula) {
  // Faces, edges and vertices that rays along the axes meet exactly, none of them in a plane across an axis.
  const TriangleMesh octahedron{
      {{8, 0, 0}, {-8, 0, 0}, {0, 8, 0}, {0, -8, 0}, {0, 0, 8}, {0, 0, -8}},
      {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  const Referee referee = referee_of(octahedron);
  for (int x = -9; x <= 9; ++x) {
    for (int y = -9; y <= 9; ++y) {
      for (int z = -9; z <= 9; ++z) {
        const double sum = std::abs(x) + std::abs(y) + std::abs(z);
        if (sum == 8) continue;  // on the surface
        ASSERT_EQ(referee.signed_distance(0, Vec3(x, y, z)) < 0, sum < 8) << x << ' ' << y << ' ' << z;
      }
    }
  }
}

TEST(Referee, PointsOnTheSurfaceAreFinite) {
  const TriangleMesh mesh = make_capsule(0.02, 0.05, 12);
  const Referee referee = referee_of(mesh);
  for (const Vec3& vertex : mesh.vertices) {
    const SurfaceDistance found = referee.closest(0, vertex);
    EXPECT_EQ(found.signed_distance_m, 0);
    EXPECT_FALSE(std::signbit(found.signed_distance_m));
    EXPECT_NEAR(found.normal.norm(), 1, 1e-12);
  }
  for (const Vec3& point : naive::edge_midpoints(mesh)) {
    const SurfaceDistance found = referee.closest(0, point);
    EXPECT_NEAR(found.signed_distance_m, 0, 1e-16);
    EXPECT_NEAR(found.normal.norm(), 1, 1e-12);
  }
}

/// What touches is on neither side; a depth that can be told is told.
TEST(Referee, TouchingIsNoContact) {
  const TriangleMesh mesh = make_box({0.1, 0.1, 0.1}, 2);
  const std::vector<Bone> bones{bone_of(mesh)};
  Referee referee(bones, 3);
  const std::vector<RigidMotion> poses(1);
  std::vector<Contact> truth;
  for (int i = 0; i < 2; ++i) {  // the second time its distances are cached
    referee.judge(poses, std::vector<Vec3>{{0.1 - 1e-14, 0.01, 0.02}, {0.1 - 1e-11, 0.01, 0.02}, {0.1, 0.01, 0.02}},
                  std::vector<int>{0, 1, 2}, truth);
    ASSERT_EQ(truth.size(), 1U);
    EXPECT_EQ(truth[0].node, 1);
  }
}

TEST(Referee, FinWithoutThicknessTurnsNothingInsideOut) {
  TriangleMesh mesh = make_sphere(1, 3);
  const Triangle root = mesh.triangles[100];
  const Vec3 out = mesh.vertices[static_cast<std::size_t>(root[0])];
  const int tip = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(1.5 * out);
  mesh.triangles.push_back({root[0], root[1], tip});
  mesh.triangles.push_back({root[1], root[0], tip});
  expect_exact_everywhere(mesh, 300, 9);
  const Referee referee = referee_of(mesh);
  const Vec3 across = out.cross(mesh.vertices[static_cast<std::size_t>(root[1])]).normalized();
  for (const double side : {-0.01, 0.01}) {
    EXPECT_NEAR(referee.signed_distance(0, 1.4 * out + side * across), 0.01, 1e-3);
  }
}

TEST(Referee, OverlappingAndNestedComponents) {
  TriangleMesh mesh = make_box(Vec3(1, 1, 1), 3);
  append(mesh, moved(make_box(Vec3(1, 1, 1), 2), Vec3(1.3, 0.2, 0.1)));
  append(mesh, make_sphere(0.3, 2));
  expect_exact_everywhere(mesh, 400, 10);
  const Referee referee = referee_of(mesh);
  EXPECT_LT(referee.signed_distance(0, Vec3(0.6, 0, 0)), 0) << "in the overlap";
  EXPECT_LT(referee.signed_distance(0, Vec3(0, 0, 0)), 0) << "in the nested sphere";
}

TEST(Referee, SurfacesThatTouchAlongAnEdge) {
  TriangleMesh mesh = make_box(Vec3(1, 1, 1), 1);
  append(mesh, moved(make_box(Vec3(1, 1, 1), 1), Vec3(2, 2, 0)));
  expect_exact_everywhere(mesh, 400, 11);
}

TEST(Referee, FlippedTrianglesAreMendedByTheRepair) {
  const TriangleMesh whole = make_capsule(0.02, 0.05, 24);
  TriangleMesh flipped = whole;
  for (const std::size_t i : {3U, 4U, 77U, 200U}) std::swap(flipped.triangles[i][0], flipped.triangles[i][1]);
  const Referee right = referee_of(whole);
  const Referee mended = referee_of(repair_mesh(flipped, "flipped").mesh);
  std::mt19937_64 random(12);
  for (const Vec3& point : naive::cloud(whole, 2000, random)) {
    ASSERT_NEAR(mended.signed_distance(0, point), right.signed_distance(0, point), 1e-16);
  }
}

TEST(Referee, OpenSurfaceIsJudgedByItsWindingNumber) {
  TriangleMesh open = make_box(Vec3(1, 1, 1), 4);
  std::erase_if(open.triangles, [&](const Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](int v) { return open.vertices[static_cast<std::size_t>(v)].z() == 1; });
  });
  std::mt19937_64 random(13);
  expect_exact(open, naive::cloud(open, 500, random));
}

TEST(Referee, FarFromTheOrigin) {
  TriangleMesh mesh = moved(make_capsule(0.02, 0.05, 16), Vec3(1000, -1000, 500));
  expect_exact_everywhere(mesh, 300, 14);
}

TEST(Referee, ScalingByAPowerOfTwoScalesTheAnswerBitByBit) {
  const double factor = 0x1p10;
  const TriangleMesh mesh = moved(make_capsule(0.02, 0.05, 24), Vec3(0.1, 0.2, -0.3));
  TriangleMesh large = mesh;
  for (Vec3& vertex : large.vertices) vertex *= factor;
  const Referee referee = referee_of(mesh);
  const Referee large_referee = referee_of(large);
  std::mt19937_64 random(15);
  for (const Vec3& point : naive::near_surface(mesh, 3000, 5e-3, random)) {
    const SurfaceDistance found = referee.closest(0, point);
    const SurfaceDistance large_found = large_referee.closest(0, factor * point);
    ASSERT_EQ(factor * found.signed_distance_m, large_found.signed_distance_m);
    ASSERT_EQ(factor * found.closest_point_m, large_found.closest_point_m);
    ASSERT_EQ(found.normal, large_found.normal);
  }
}

TEST(Referee, BoneWithoutTrianglesIsAnError) {
  const std::vector<Bone> bones{{"sacrum", {}}};
  try {
    const Referee referee(bones, 1);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("sacrum"), std::string::npos);
  }
}

}  // namespace
}  // namespace musclebench
