#include "core/referee/muscle_referee.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// Two cubes of 2 cm, the second one beside the first: its nodes come after those of the first.
struct TwoCubes {
  TriangleMesh mesh;
  std::vector<Body> bodies;

  TwoCubes() {
    const TriangleMesh cube = make_box(Vec3::Constant(0.01), 2);
    const auto nodes = static_cast<int>(cube.vertices.size());
    mesh = cube;
    for (const Vec3& vertex : cube.vertices) mesh.vertices.push_back(vertex + Vec3(0.03, 0, 0));
    for (const auto& [a, b, c] : cube.triangles) mesh.triangles.push_back({a + nodes, b + nodes, c + nodes});
    bodies = {{"first", 0, nodes, 0, cube.triangles.size()},
              {"second", nodes, 2 * nodes, cube.triangles.size(), 2 * cube.triangles.size()}};
  }
};

TEST(MuscleReferee, TellsDistancesFromMusclesWhereTheyAre) {
  const TwoCubes cubes;
  MuscleReferee referee(cubes.mesh, {cubes.bodies, {{1}, {0}}});
  std::vector<Vec3> positions = cubes.mesh.vertices;
  std::vector<Contact> truth;
  for (const double by_m : {0.0, -0.004}) {
    for (int node = cubes.bodies[1].first_node; node < cubes.bodies[1].last_node; ++node) {
      const auto index = static_cast<std::size_t>(node);
      positions[index] = cubes.mesh.vertices[index] + Vec3(by_m, 0, 0);
    }
    referee.judge(positions, truth);
    const SurfaceDistance outside = referee.distance(1, Vec3(0.015, 0.001, 0.002));
    EXPECT_NEAR(outside.signed_distance_m, 0.005 + by_m, 1e-15);
    EXPECT_LT((outside.normal - Vec3(-1, 0, 0)).norm(), 1e-12);
    EXPECT_LT((outside.closest_point_m - Vec3(0.02 + by_m, 0.001, 0.002)).norm(), 1e-15);
    const SurfaceDistance inside = referee.distance(1, Vec3(0.021 + by_m, 0.001, 0.002));
    EXPECT_NEAR(inside.signed_distance_m, -0.001, 1e-15);
    EXPECT_LT((inside.normal - Vec3(-1, 0, 0)).norm(), 1e-9);
    const SurfaceDistance on_it = referee.distance(1, Vec3(0.02 + by_m, 0.001, 0.002));
    EXPECT_NEAR(on_it.signed_distance_m, 0, 1e-15);
    EXPECT_LT((on_it.normal - Vec3(-1, 0, 0)).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace musclebench
