#include "bench/cases/verification.hpp"

#include <set>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

const auto silent = [](const std::string& /*stage*/, int /*done*/, int /*total*/) {};

SurfaceVerification verify(const TriangleMesh& mesh, bool repaired, int threads = 1) {
  const Bone bone{"bone", repaired ? repair_mesh(mesh, "bone") : RepairedMesh{mesh, false, {}}};
  VerificationSettings settings;
  settings.points = 4000;
  settings.brute_force_points = 1000;
  settings.threads = threads;
  return verify_surface(bone, settings, silent);
}

/// Two overlapping shapes and a fin without thickness; some triangles have no area.
TriangleMesh troublesome() {
  TriangleMesh mesh = make_capsule(0.02, 0.05, 24);
  const TriangleMesh box = make_box({0.03, 0.01, 0.02}, 3);
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), box.vertices.begin(), box.vertices.end());
  for (const auto& [a, b, c] : box.triangles) {
    mesh.triangles.push_back({a + first, b + first, c + first});
  }
  const auto tip = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(0.05, 0.03, 0);
  mesh.triangles.insert(mesh.triangles.end(),
                        {{first, first + 1, tip}, {first + 1, first, tip}, {first, first, tip}, {tip, tip, tip}});
  return mesh;
}

TEST(Verification, TheThreeAgreeOnCleanAndOnTroublesomeSurfaces) {
  for (const TriangleMesh& mesh : {make_sphere(0.03, 3), make_box({0.02, 0.03, 0.04}, 4), troublesome()}) {
    for (const bool repaired : {true, false}) {
      const SurfaceVerification result = verify(mesh, repaired);
      EXPECT_TRUE(result.held());
      EXPECT_EQ(result.pairs[0].points, 4000);
      EXPECT_EQ(result.pairs[2].points, 1000);
      EXPECT_GT(result.pairs[0].inside, 400);
      EXPECT_LT(result.pairs[0].inside, 3600);
    }
  }
}

TEST(Verification, AFlippedTriangleIsJudgedByTheSameDefinition) {
  TriangleMesh mesh = make_sphere(0.03, 3);
  for (const std::size_t t : {5U, 77U, 300U}) {
    std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  }
  const SurfaceVerification result = verify(mesh, false);
  EXPECT_TRUE(result.held());
  EXPECT_EQ(result.pairs[0].points, 1000);  // not closed: fewer
}

TEST(Verification, OverlappingSpheresHoldThoughTheirPseudoNormalsWouldNot) {
  // Inside one, the other's surface looks like a way out; and a mesh that claims to be clean is not believed.
  TriangleMesh mesh = make_sphere(0.03, 3);
  const auto first = static_cast<int>(mesh.vertices.size());
  const TriangleMesh other = make_sphere(0.03, 3);
  for (const Vec3& vertex : other.vertices) {
    mesh.vertices.emplace_back(vertex + Vec3(0.02, 0, 0));
  }
  for (const auto& [a, b, c] : other.triangles) {
    mesh.triangles.push_back({a + first, b + first, c + first});
  }
  VerificationSettings settings;
  settings.points = 2000;
  settings.brute_force_points = 500;
  const SurfaceVerification result = verify_surface({"overlap", {mesh, true, {}}}, settings, silent);
  EXPECT_TRUE(result.held());
  EXPECT_EQ(result.pairs[0].sign_differences, 0);
  EXPECT_EQ(result.pairs[1].sign_differences, 0);
  EXPECT_EQ(result.pairs[2].sign_differences, 0);
}

TEST(Verification, ABoneFarFromTheOriginIsJudgedByItsRounding) {
  for (const double offset_m : {1.0, 1e3, 1e6}) {
    TriangleMesh mesh = make_box({0.02, 0.03, 0.04}, 4);
    for (Vec3& vertex : mesh.vertices) {
      vertex += offset_m * Vec3(1, 2, -3);
    }
    const SurfaceVerification result = verify(mesh, true);
    EXPECT_TRUE(result.held()) << offset_m;
    EXPECT_LE(result.pairs[0].largest_difference_m, 1e-15);
  }
}

TEST(Verification, ADifferenceOrANumberThatIsNoneDoesNotHold) {
  SurfaceVerification result;
  result.diagonal_m = 1;
  result.agreed_m = agreed_share;
  result.pairs.resize(3);
  EXPECT_TRUE(result.held());
  result.pairs[1].largest_difference_m = 1.1e-12;
  EXPECT_FALSE(result.held());
  result.pairs[1].largest_difference_m = std::nan("");
  EXPECT_FALSE(result.held());
}

TEST(Verification, ThreadsChangeNothing) {
  const SurfaceVerification alone = verify(troublesome(), true);
  const SurfaceVerification shared = verify(troublesome(), true, 3);
  EXPECT_EQ(alone.pairs[0].largest_difference_m, shared.pairs[0].largest_difference_m);
  EXPECT_EQ(alone.pairs[0].inside, shared.pairs[0].inside);
}

TEST(Verification, PointsAreFixedByTheSeedAndALongerListBeginsWithAShorter) {
  const TriangleMesh box = make_box({1, 1, 1}, 2);
  const std::vector<Vec3> few = points_about(box, 50, 3);
  const std::vector<Vec3> many = points_about(box, 500, 3);
  EXPECT_TRUE(std::equal(few.begin(), few.end(), many.begin()));
  EXPECT_NE(many[0], points_about(box, 1, 4)[0]);
  int outside_box = 0;
  int vertices = 0;
  for (const Vec3& point : many) {
    outside_box += point.cwiseAbs().maxCoeff() > 1 ? 1 : 0;
    vertices += (point.cwiseAbs().array() == 0 || point.cwiseAbs().array() == 1).all() ? 1 : 0;
    EXPECT_LE(point.cwiseAbs().maxCoeff(), 1.2);
  }
  EXPECT_GT(outside_box, 80);
  EXPECT_GT(vertices, 40);
}

}  // namespace
}  // namespace musclebench
