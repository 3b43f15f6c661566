#include "backends/fcl/boxed_surface.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/bvh/tests/closest_by_brute_force.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

struct Case {
  const char* name;
  RepairedMesh surface;
  double size_m;
  Vec3 centre;
};

/// Turned, so that boxes are not faces.
TriangleMesh moved(TriangleMesh mesh, const Vec3& by) {
  const RigidMotion motion = RigidMotion::about_axis(Vec3(1, -2, 0.5).normalized(), Vec3::Zero(), 0.7);
  for (Vec3& vertex : mesh.vertices) {
    vertex = motion.apply(vertex) + by;
  }
  return mesh;
}

/// A ball with slivers of all kinds that stand out of it.
TriangleMesh with_needles(TriangleMesh ball) {
  const std::size_t count = ball.triangles.size();
  for (std::size_t t = 0; t < count; t += 2) {
    const auto [a, b, c] = ball.triangles[t];
    const Vec3 foot = ball.vertices[static_cast<std::size_t>(a)];
    const Vec3 across = ball.vertices[static_cast<std::size_t>(b)] - foot;
    const double thin = std::pow(10.0, -4.0 - static_cast<double>(t % 7));
    ball.vertices.emplace_back(1.5 * foot);
    ball.vertices.emplace_back(1.2 * foot + 3 * thin * across);
    const auto tip = static_cast<int>(ball.vertices.size()) - 2;
    ball.triangles.push_back({a, tip, tip + 1});
    ball.triangles.push_back({tip, a, tip + 1});
  }
  return ball;
}

std::vector<Case> cases() {
  const Vec3 away(1e4, -2e4, 3e4);  // with fewer digits than a touching distance
  return {{"box", {make_box({0.01, 0.02, 0.03}, 4), true, {}}, 0.03, Vec3::Zero()},
          {"ball", {make_sphere(0.02, 3), true, {}}, 0.02, Vec3::Zero()},
          {"slivers", {with_needles(make_sphere(0.02, 2)), true, {}}, 0.02, Vec3::Zero()},
          {"turned", {moved(make_box({0.01, 0.02, 0.03}, 4), Vec3::Zero()), true, {}}, 0.03, Vec3::Zero()},
          {"far", {moved(make_box({0.01, 0.02, 0.03}, 4), away), true, {}}, 0.03, away},
          {"far ball", {moved(make_sphere(0.02, 3), away), true, {}}, 0.02, away}};
}

/// Anywhere, near, and where many triangles are at the same distance: in the middle, on planes of symmetry, at
/// vertices and edges and beyond them.
std::vector<Vec3> points_of(const Case& about) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  const auto direction = [&] {
    const double x = normal(random), y = normal(random);
    return Vec3(x, y, normal(random));
  };
  std::vector<Vec3> points = {about.centre};
  for (int i = 0; i < 60; ++i) {
    points.push_back(about.centre + 0.6 * about.size_m * direction());
    Vec3 symmetric = about.centre + 0.6 * about.size_m * direction();
    symmetric[i % 3] = about.centre[i % 3];
    points.push_back(symmetric);
    const auto& vertices = about.surface.mesh.vertices;
    const Vec3& vertex = vertices[static_cast<std::size_t>(i) * 37 % vertices.size()];
    points.push_back(vertex);
    points.push_back(vertex + 0.2 * (vertex - about.centre));
    points.push_back(vertex - 0.01 * (vertex - about.centre));
    points.push_back(vertex + 0.2 * (vertex - about.centre) + 0.02 * about.size_m * direction());
    points.push_back(vertex + 1e-3 * about.size_m * direction());
    const auto& triangles = about.surface.mesh.triangles;
    const auto [a, b, c] = triangles[static_cast<std::size_t>(i) * 41 % triangles.size()];
    const Vec3 edge = (vertices[static_cast<std::size_t>(a)] + vertices[static_cast<std::size_t>(b)]) / 2;
    points.push_back(edge + 0.1 * (edge - about.centre));
    points.push_back(edge - 0.1 * (edge - about.centre));
  }
  return points;
}

class CountedSurface : public BoxedSurface {
 public:
  explicit CountedSurface(const RepairedMesh& surface)
      : BoxedSurface(surface), m_triangles(static_cast<int>(surface.mesh.triangles.size())) {}

  [[nodiscard]] ClosestPoint by_brute_force(const Vec3& point) const {
    return closest_by_brute_force(m_triangles, [&](int triangle) { return closest_on(point, triangle); });
  }
  /// In no order.
  int next_triangle() { return m_next = (m_next + 101) % m_triangles; }

 private:
  int m_triangles;
  int m_next = 0;
};

TEST(BoxedSurface, SearchesAnswerWhatBruteForceDoesToTheBit) {
  for (const Case& about : cases()) {
    SCOPED_TRACE(about.name);
    CountedSurface surface(about.surface);
    for (const Vec3& point : points_of(about)) {
      const ClosestPoint expected = surface.by_brute_force(point);
      expect_equal(surface.closest(point, -1), expected);
      expect_equal(surface.closest(point, expected.triangle), expected);
      expect_equal(surface.closest(point, surface.next_triangle()), expected);
    }
  }
}

TEST(BoxedSurface, ListsAnswerWhatBruteForceDoesWhereTheyAreCertain) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal(0, 1);
  for (const Case& about : cases()) {
    SCOPED_TRACE(about.name);
    const CountedSurface surface(about.surface);
    int certain = 0;
    int asked = 0;
    for (const Vec3& place : points_of(about)) {
      const double distance_m = surface.by_brute_force(place).distance_m;
      NearTriangles list;
      surface.list_candidates(place, distance_m, list);
      ASSERT_GT(list.count, 0U);
      for (const double way : {0.0, 0.2, 0.7, 1.5, 3.0, 20.0}) {
        const double x = normal(random), y = normal(random);
        const Vec3 point = place + way * surface.near_m() * Vec3(x, y, normal(random)).normalized();
        BoxedSurface::CandidateSearch search;
        surface.begin_candidate_search(point, list, search);
        const ClosestCandidate found =
            surface.finish_candidate_search(list, std::numeric_limits<double>::infinity(), search);
        EXPECT_EQ(found.clearance_m, 0);
        EXPECT_FALSE(way == 20 && distance_m < surface.near_m() && found.certain);
        if (found.certain) {
          expect_equal(found.closest, surface.by_brute_force(point));
        }
        asked += static_cast<int>(way < 0.5 && distance_m < surface.near_m());
        certain += static_cast<int>(way < 0.5 && distance_m < surface.near_m() && found.certain);
      }
    }
    EXPECT_GT(asked, 100);
    // What is said of one sliver is nothing, so that lists with many of them are never certain.
    EXPECT_GT(certain, about.name == std::string("slivers") ? 0 : asked * 9 / 10);
  }
}

TEST(BoxedSurface, ClearancesAreTrueAndNotMuchLessThanTheDistance) {
  for (const Case& about : cases()) {
    SCOPED_TRACE(about.name);
    CountedSurface surface(about.surface);
    for (const Vec3& point : points_of(about)) {
      const double distance_m = surface.by_brute_force(point).distance_m;
      const Clearance found = surface.clearance(point, surface.next_triangle());
      EXPECT_LE(found.distance_m, distance_m);
      EXPECT_GE(found.distance_m, 0.79 * distance_m - 1e-9);
      ASSERT_GE(found.triangle, 0);
      EXPECT_LE(surface.distance_m(point, found.triangle), 1.27 * distance_m + 1e-9);
    }
  }
}

TEST(BoxedSurface, AHoleIsNoClearance) {
  TriangleMesh mesh = make_sphere(0.02, 3);
  mesh.triangles.pop_back();
  const BoxedSurface surface({mesh, true, {}});
  const Vec3 point(0.001, 0.002, 0.003);
  EXPECT_EQ(surface.clearance(point, 0).distance_m, 0);
  EXPECT_EQ(surface.side(point, surface.closest(point, -1)).clearance_m, 0);
}

TEST(BoxedSurface, CountsTheTreeOfBoxes) {
  const RepairedMesh surface = {make_sphere(0.02, 3), true, {}};
  // Two nodes a triangle, each a box of six numbers and at least three integers.
  const std::size_t nodes = 2 * surface.mesh.triangles.size() * (6 * sizeof(double) + 3 * sizeof(int));
  EXPECT_GT(BoxedSurface(surface).bytes(), SignedSurface(surface).bytes() + nodes);
}

}  // namespace
}  // namespace musclebench
