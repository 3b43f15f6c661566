#include "core/bvh/moving_surface_tree.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/bvh/tests/closest_by_brute_force.hpp"
#include "core/distance/pseudo_normals.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// A capsule and, beside it, a sphere: two bodies in one mesh.
struct TwoBodies {
  TriangleMesh mesh = make_capsule(0.02, 0.05, 24);
  std::vector<Body> bodies;

  TwoBodies() {
    const TriangleMesh sphere = make_sphere(0.03, 3);
    const auto first_node = static_cast<int>(mesh.vertices.size());
    const std::size_t first_triangle = mesh.triangles.size();
    for (const Vec3& vertex : sphere.vertices) mesh.vertices.push_back(vertex + Vec3(0.06, 0, 0));
    for (const auto& [a, b, c] : sphere.triangles) {
      mesh.triangles.push_back({first_node + a, first_node + b, first_node + c});
    }
    bodies = {{"capsule", 0, first_node, 0, first_triangle},
              {"sphere", first_node, static_cast<int>(mesh.vertices.size()), first_triangle, mesh.triangles.size()}};
  }

  /// Bent and twisted, the more the larger `amount`.
  [[nodiscard]] std::vector<Vec3> deformed(double amount) const {
    std::vector<Vec3> moved;
    for (const Vec3& v : mesh.vertices) {
      const double angle = amount * 8 * v.z();
      const Vec3 twisted(std::cos(angle) * v.x() - std::sin(angle) * v.y(),
                         std::sin(angle) * v.x() + std::cos(angle) * v.y(), v.z() + amount * 0.4 * v.x());
      moved.emplace_back(twisted + amount * Vec3(0.01, -0.02, 0.03));
    }
    return moved;
  }

  [[nodiscard]] ClosestPoint brute_force(std::span<const Vec3> vertices, const Body& body, const Vec3& point) const {
    ClosestPoint found =
        closest_by_brute_force(static_cast<int>(body.last_triangle - body.first_triangle), [&](int triangle) {
          const auto& [a, b, c] = mesh.triangles[body.first_triangle + static_cast<std::size_t>(triangle)];
          return closest_on_triangle(point, vertices[static_cast<std::size_t>(a)],
                                     vertices[static_cast<std::size_t>(b)], vertices[static_cast<std::size_t>(c)]);
        });
    found.triangle += static_cast<int>(body.first_triangle);
    return found;
  }
};

TEST(MovingSurfaceTree, AnswersAsBruteForceHoweverFarTheVerticesHaveTravelled) {
  const TwoBodies two;
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> coordinate(-0.12, 0.12);
  for (const Body& body : two.bodies) {
    MovingSurfaceTree tree(two.mesh, body);
    const int refits_at_first = tree.refits();
    int steps = 0;
    for (double amount = 0; amount <= 1; amount += 1.0 / 512, ++steps) {
      const std::vector<Vec3> vertices = two.deformed(amount);
      tree.update(vertices, 1 + steps % 2);
      for (int i = 0; i < 8; ++i) {
        const double x = coordinate(generator);
        const double y = coordinate(generator);
        const Vec3 point(x, y, coordinate(generator));
        const ClosestPoint expected = two.brute_force(vertices, body, point);
        const int guess = i % 2 == 0 ? -1 : static_cast<int>(body.first_triangle) + i;
        expect_equal(tree.closest_point(point, guess), expected);
        EXPECT_LE(tree.box_distance_m(point), expected.distance_m);
        // A vertex of the surface itself: several triangles at the same distance.
        const Vec3& vertex = vertices[static_cast<std::size_t>(body.first_node + i)];
        expect_equal(tree.closest_point(vertex, guess), two.brute_force(vertices, body, vertex));
      }
    }
    EXPECT_GT(tree.refits(), refits_at_first) << "nothing was refitted: the test moved too little";
    EXPECT_LT(tree.refits(), steps) << "a refit in every step";
  }
}

TEST(MovingSurfaceTree, FindsNothingBeyondTheLargestDistanceOrForAPointThatIsNone) {
  const TwoBodies two;
  const MovingSurfaceTree tree(two.mesh, two.bodies[0]);
  const Vec3 point(0.05, 0, 0);
  const double distance_m = tree.closest_point(point).distance_m;
  EXPECT_GE(tree.closest_point(point, -1, 1.001 * distance_m).triangle, 0);
  EXPECT_LT(tree.closest_point(point, -1, 0.999 * distance_m).triangle, 0);
  EXPECT_LT(tree.closest_point(Vec3(NAN, 0, 0), 3).triangle, 0);
}

double winding_by_angles(const TwoBodies& two, std::span<const Vec3> vertices, const Body& body, const Vec3& point) {
  double angle = 0;
  for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
    const auto& [a, b, c] = two.mesh.triangles[t];
    angle += solid_angle(point, vertices[static_cast<std::size_t>(a)], vertices[static_cast<std::size_t>(b)],
                         vertices[static_cast<std::size_t>(c)]);
  }
  return angle / (4 * std::numbers::pi);
}

TEST(MovingSurfaceTree, CountsTheWindingsOfAFoldedSurfaceToo) {
  const TwoBodies two;
  std::mt19937 generator(6);
  std::uniform_real_distribution<double> coordinate(-0.09, 0.09);
  for (const Body& body : two.bodies) {
    MovingSurfaceTree tree(two.mesh, body);
    int inside = 0;
    int twice = 0;
    int negative = 0;
    for (double amount = 0; amount <= 1; amount += 1.0 / 32) {
      std::vector<Vec3> vertices = two.deformed(amount);
      // Pushed through the opposite side: parts are covered twice, or inside out.
      for (int i = body.first_node; i < body.last_node; ++i) {
        Vec3& vertex = vertices[static_cast<std::size_t>(i)];
        if (vertex.z() > 0.01) vertex.z() = 0.02 - 2 * amount * vertex.z();
      }
      tree.update(vertices, 1);
      for (int i = 0; i < 300; ++i) {
        const double x = coordinate(generator) + (body.first_node == 0 ? 0 : 0.05);
        const double y = 0.3 * coordinate(generator);
        const Vec3 point(x, y, coordinate(generator));
        const double expected = winding_by_angles(two, vertices, body, point);
        ASSERT_NEAR(tree.winding_number(point), expected, 1e-6) << amount << ": " << point.transpose();
        inside += expected > 0.5 ? 1 : 0;
        twice += expected > 1.5 ? 1 : 0;
        negative += expected < -0.5 ? 1 : 0;
      }
      // Straight above a vertex, below an edge: rays that graze what they meet.
      for (int i = body.first_node; i < body.last_node; i += 7) {
        const Vec3& vertex = vertices[static_cast<std::size_t>(i)];
        for (const Vec3& offset : {Vec3(0.004, 0, 0), Vec3(-0.004, 0, 0), Vec3(0, 0, 0.004), Vec3(0, -0.004, 0)}) {
          const Vec3 point = vertex + offset;
          const double expected = winding_by_angles(two, vertices, body, point);
          if (std::abs(expected - std::round(expected)) > 1e-6) continue;  // on another part of the surface
          ASSERT_NEAR(tree.winding_number(point), expected, 1e-6);
        }
      }
    }
    EXPECT_GT(inside, 60);
    EXPECT_GT(twice + negative, 30) << "nothing was folded";
  }
}

TEST(MovingPseudoNormals, AreThoseOfAMeshWithTheseVertices) {
  TwoBodies two;
  const MovingPseudoNormals moving(two.mesh);
  const TriangleMesh bent{two.deformed(0.7), two.mesh.triangles};
  const PseudoNormals expected(bent);
  for (int triangle = 0; triangle < static_cast<int>(bent.triangles.size()); ++triangle) {
    for (const Feature feature : {Feature::face, Feature::edge_0, Feature::edge_1, Feature::edge_2, Feature::corner_0,
                                  Feature::corner_1, Feature::corner_2}) {
      ASSERT_EQ(moving.at(bent.vertices, triangle, feature), expected.at(triangle, feature)) << triangle;
    }
  }
}

}  // namespace
}  // namespace musclebench
