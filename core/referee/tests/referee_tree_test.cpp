#include "core/referee/referee_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/referee/tests/naive_truth.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

TEST(RefereeTree, RefittedAnswersLikeNew) {
  const TriangleMesh rest = make_capsule(0.1, 0.3, 20);
  RefereeTree tree(rest);
  std::mt19937_64 random(3);
  for (const double bend : {2.0, -3.0, 0.0}) {
    TriangleMesh mesh = moved(rest, some_motion());
    for (Vec3& p : mesh.vertices) p.x() += bend * p.z() * p.z();
    tree.refit(mesh.triangles, mesh.vertices);
    std::vector<Vec3> points = naive::cloud(mesh, 200, random);
    for (const Vec3& point : naive::near_surface(mesh, 200, 0.01, random)) points.push_back(point);
    for (const Vec3& point : points) {
      const Vec3 local = point - tree.centre_m();
      const double distance = std::sqrt(tree.closest(local).squared_distance_m2);
      const double reach = 1e-12 * (naive::diagonal(mesh) + local.norm() + 10);
      ASSERT_NEAR(distance, naive::distance(mesh, point), reach);
      if (distance > reach) {
        ASSERT_NEAR(tree.winding_number(local), naive::winding_number(mesh, point), 1e-6);
      }
      ASSERT_LE(tree.box_distance(local), distance + reach);
    }
  }
}

TriangleMesh capsule_with_holes(std::size_t missing, std::mt19937_64& random) {
  TriangleMesh mesh = make_capsule(0.1, 0.3, 16);
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
  mesh.triangles.resize(mesh.triangles.size() - missing);
  return mesh;
}

TEST(RefereeTree, WindingNumberOfOpenSurfacesIsTheSumOfSolidAngles) {
  std::mt19937_64 random(17);
  for (const std::size_t missing : {1, 2, 25, 300}) {
    TriangleMesh mesh = capsule_with_holes(missing, random);
    mesh.triangles.push_back(mesh.triangles[3]);  // an edge that is used more often one way than the other
    mesh.triangles.push_back({mesh.triangles[5][0], mesh.triangles[5][0], mesh.triangles[5][1]});
    const RefereeTree tree(mesh);
    EXPECT_FALSE(tree.closed());
    std::vector<Vec3> points = naive::cloud(mesh, 500, random);
    for (const Vec3& point : naive::near_surface(mesh, 500, 1e-3, random)) points.push_back(point);
    for (const Vec3& point : points) {
      ASSERT_NEAR(tree.winding_number(point - tree.centre_m()), naive::winding_number(mesh, point), 1e-9);
    }
  }
}

TEST(RefereeTree, ASideHoldsForAsLongAsItSays) {
  std::mt19937_64 random(19);
  std::normal_distribution<double> normal;
  for (const std::size_t missing : {1, 40}) {
    const TriangleMesh mesh = capsule_with_holes(missing, random);
    const RefereeTree tree(mesh);
    int used = 0;
    for (const Vec3& point : naive::cloud(mesh, 300, random)) {
      const Vec3 local = point - tree.centre_m();
      const SurfaceWinding winding = tree.winding(local);
      EXPECT_EQ(winding.number, tree.winding_number(local));
      const double distance = std::sqrt(tree.closest(local).squared_distance_m2);
      const double reach = 0.999 * std::min(distance, winding.steady_m);
      used += reach > 0.1 * distance ? 1 : 0;
      for (int i = 0; i < 10; ++i) {
        // Half of the movement is the point's, half that of the vertices, each in a direction of its own.
        const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
        TriangleMesh deformed = mesh;
        for (Vec3& vertex : deformed.vertices) {
          vertex += 0.5 * reach * Vec3(normal(random), normal(random), normal(random)).normalized();
        }
        const double after = naive::winding_number(deformed, point + 0.5 * reach * direction);
        ASSERT_EQ(after > 0.5, winding.number > 0.5);
      }
    }
    EXPECT_GT(used, 150);
  }
  EXPECT_EQ(RefereeTree(make_capsule(0.1, 0.3, 16)).winding(Vec3::Zero()).steady_m,
            std::numeric_limits<double>::infinity());
}

/// Crossings of the triangle's edges with the surface and of the surface's edges with the triangle.
bool plainly_meets(const TriangleMesh& mesh, const std::array<Vec3, 3>& blade) {
  const auto cuts = [](const Vec3& from, const Vec3& to, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 n = (b - a).cross(c - a);
    const double start = n.dot(from - a);
    const double end = n.dot(to - a);
    if (start * end > 0) return false;
    const Vec3 p = from + (to - from) * (start / (start - end));
    return n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 && n.dot((a - c).cross(p - c)) >= 0;
  };
  for (const Triangle& t : mesh.triangles) {
    std::array<Vec3, 3> other;
    for (std::size_t k = 0; k < 3; ++k) other[k] = mesh.vertices[static_cast<std::size_t>(t[k])];
    for (std::size_t k = 0; k < 3; ++k) {
      if (cuts(blade[k], blade[(k + 1) % 3], other[0], other[1], other[2])) return true;
      if (cuts(other[k], other[(k + 1) % 3], blade[0], blade[1], blade[2])) return true;
    }
  }
  return false;
}

TEST(RefereeTree, MeetsWhatPlainlyCrosses) {
  const TriangleMesh mesh = make_capsule(0.1, 0.3, 12);
  const RefereeTree tree(mesh);
  std::mt19937_64 random(5);
  std::normal_distribution<double> size(0, 0.1);
  int met = 0;
  const std::vector<Vec3> middles = naive::near_surface(mesh, 3000, 0.05, random);
  for (const Vec3& middle : middles) {
    std::array<Vec3, 3> blade;
    for (Vec3& corner : blade) corner = middle + Vec3(size(random), size(random), size(random));
    const bool expected = plainly_meets(mesh, blade);
    const Vec3& centre = tree.centre_m();
    ASSERT_EQ(tree.find_touched(blade[0] - centre, blade[1] - centre, blade[2] - centre) >= 0, expected);
    met += expected ? 1 : 0;
  }
  EXPECT_GT(met, 1000);
  EXPECT_LT(met, 2900);
}

TEST(RefereeTree, TouchingMeets) {
  const RefereeTree tree(make_box({1, 1, 1}, 2));
  EXPECT_GE(tree.find_touched({-3, -3, 1}, {3, -3, 1}, {0, 3, 1}), 0);         // in the plane of a face
  EXPECT_GE(tree.find_touched({0.3, 0.2, 1}, {0.5, 1, 3}, {0.2, 0.7, 3}), 0);  // with a corner
  EXPECT_EQ(tree.find_touched({-3, -3, 1.0001}, {3, -3, 1.0001}, {0, 3, 1.0001}), -1);
  EXPECT_EQ(tree.find_touched({-0.3, -0.3, 0}, {0.3, -0.3, 0}, {0, 0.3, 0}), -1);  // inside
}

TEST(RefereeTree, CrossingsInOrder) {
  TriangleMesh mesh = make_box({1, 1, 1}, 2);
  append(mesh, moved(make_box({1, 1, 1}, 2), Vec3(4, 0, 0)));
  const RefereeTree tree(mesh);
  const Vec3& centre = tree.centre_m();
  std::vector<SurfaceCrossing> crossings;
  tree.cross(Vec3(-2, 0.1, 0.3) - centre, Vec3(6, 0.1, 0.3) - centre, crossings);
  ASSERT_EQ(crossings.size(), 4);
  const double shares[] = {0.125, 0.375, 0.625, 0.875};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(crossings[i].share, shares[i], 1e-15);
    EXPECT_EQ(crossings[i].entering, i % 2 == 0);
    EXPECT_EQ(tree.face_normal(crossings[i].slot), Vec3(i % 2 == 0 ? -1 : 1, 0, 0));
  }
  tree.cross(Vec3(-2, 0.1, 1.3) - centre, Vec3(6, 0.1, 1.3) - centre, crossings);
  EXPECT_TRUE(crossings.empty());
}

/// Also through edges, whose coordinates are exact here: leaving less entering is what changes the
/// winding number.
TEST(RefereeTree, CrossingsSumToTheWindingNumber) {
  const TriangleMesh mesh = make_box({1, 1, 1}, 4);
  const RefereeTree tree(mesh);
  std::mt19937_64 random(11);
  std::uniform_int_distribution<int> slot(-6, 6);
  std::vector<SurfaceCrossing> crossings;
  int checked = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 from(0.25 * slot(random), 0.25 * slot(random), 0.25 * slot(random));
    const Vec3 to(0.25 * slot(random), 0.25 * slot(random), 0.25 * slot(random));
    const double reach_from = from.lpNorm<Eigen::Infinity>();
    const double reach_to = to.lpNorm<Eigen::Infinity>();
    if (reach_from == 1 || reach_to == 1) continue;  // on the surface
    const Vec3 segment = to - from;
    const bool along_a_face = segment.cwiseAbs().minCoeff() == 0;
    const bool through_a_vertex = std::any_of(mesh.vertices.begin(), mesh.vertices.end(), [&](const Vec3& vertex) {
      return (vertex - from).cross(segment).isZero(0);
    });
    if (along_a_face || through_a_vertex) continue;
    tree.cross(from, to, crossings);
    int sum = 0;
    for (const SurfaceCrossing& crossing : crossings) sum += crossing.entering ? 1 : -1;
    ASSERT_EQ(sum, (reach_to < 1 ? 1 : 0) - (reach_from < 1 ? 1 : 0)) << from.transpose() << " to " << to.transpose();
    ++checked;
  }
  EXPECT_GT(checked, 1000);
}

/// Of one triangle: no neighbour answers for an edge that is left out.
TEST(RefereeTree, TheClosestPointOfOneTriangleIsOnTheEdgeThatFacesThePoint) {
  const TriangleMesh mesh{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, {{0, 1, 2}}};
  const std::array<std::pair<Vec3, Vec3>, 7> expected{{{Vec3(1, 1, 2), Vec3(1, 1, 0)},
                                                       {Vec3(2, -1, 1), Vec3(2, 0, 0)},
                                                       {Vec3(-1, 1, 1), Vec3(0, 1, 0)},
                                                       {Vec3(3, 3, -1), Vec3(2, 2, 0)},
                                                       {Vec3(-1, -2, 1), Vec3(0, 0, 0)},
                                                       {Vec3(6, -1, 1), Vec3(4, 0, 0)},
                                                       {Vec3(-1, 7, 1), Vec3(0, 4, 0)}}};
  for (std::size_t first = 0; first < 3; ++first) {
    TriangleMesh turned = mesh;
    auto& corners = turned.triangles[0];
    std::rotate(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(first), corners.end());
    const RefereeTree tree(turned);
    for (const auto& [point, closest] : expected) {
      const ClosestSurfacePoint found = tree.closest(point - tree.centre_m());
      EXPECT_LT((found.point_m + tree.centre_m() - closest).norm(), 1e-15);
      EXPECT_NEAR(found.squared_distance_m2, (point - closest).squaredNorm(), 1e-14);
    }
  }
}

}  // namespace
}  // namespace musclebench
