#include "backends/sdf/packet_search.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/geometry/read_mesh.hpp"
#include "core/geometry/repair_mesh.hpp"
#include "core/geometry/shapes.hpp"
#include "core/geometry/tests/lhdl_data.hpp"

namespace musclebench {
namespace {

/// Packets of all sizes and distances: all of them answered as one by one, to the bit.
void expect_answers_of_single_queries(const TriangleMesh& mesh, int packets) {
  const TriangleTree tree(mesh);
  Vec3 lower = mesh.vertices.front();
  Vec3 upper = lower;
  for (const Vec3& vertex : mesh.vertices) {
    lower = lower.cwiseMin(vertex);
    upper = upper.cwiseMax(vertex);
  }
  const double size = (upper - lower).norm();
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> unit(0, 1);
  std::uniform_int_distribution<std::size_t> vertices(0, mesh.vertices.size() - 1);
  std::uniform_int_distribution<int> triangles(0, static_cast<int>(mesh.triangles.size()) - 1);
  const auto noise = [&] { return Vec3(unit(generator) - 0.5, unit(generator) - 0.5, unit(generator) - 0.5); };
  int seed = 0;
  for (int packet = 0; packet < packets; ++packet) {
    const double away = size * std::pow(10.0, -5 * unit(generator));
    const double width = packet % 5 == 0 ? 0 : size * std::pow(10.0, -4 * unit(generator) - 0.5);
    const Vec3 middle = mesh.vertices[vertices(generator)] + (packet % 3 == 0 ? Vec3(Vec3::Zero()) : away * noise());
    std::vector<Vec3> points;
    for (std::size_t n = 0; n < 1 + static_cast<std::size_t>(packet) % PacketSearch::most_points; ++n) {
      points.push_back(middle + width * noise());
    }
    std::vector<ClosestPoint> answers(points.size());
    PacketSearch(tree).closest_points(points, packet % 4 == 0 ? triangles(generator) : seed, answers);
    for (std::size_t n = 0; n < points.size(); ++n) {
      const ClosestPoint expected = tree.closest_point(points[n]).value();
      ASSERT_EQ(answers[n].distance_m, expected.distance_m) << packet;
      ASSERT_EQ(answers[n].triangle, expected.triangle) << packet;
      ASSERT_EQ(answers[n].point, expected.point);
      ASSERT_EQ(answers[n].feature, expected.feature);
      seed = answers[n].triangle;
    }
  }
}

TEST(PacketSearch, IsThatOfSingleQueriesOnShapes) {
  expect_answers_of_single_queries(make_sphere(0.1, 4), 4000);
  expect_answers_of_single_queries(make_box({0.5, 0.2, 0.001}, 7), 4000);
  expect_answers_of_single_queries(make_capsule(0.01, 1, 32), 4000);
}

TEST(PacketSearch, IsThatOfSingleQueriesOnNeedlesAndFarFromTheOrigin) {
  std::mt19937 generator(5);
  std::normal_distribution<double> normal(0, 1);
  TriangleMesh soup;
  for (int t = 0; t < 3000; ++t) {
    const Vec3 at(50 + normal(generator), normal(generator), -30 + normal(generator));
    const Vec3 along(normal(generator), normal(generator), normal(generator));
    const double thin = t % 3 == 0 ? 1e-9 : 0.3;
    for (const double side : {0.0, 1.0, 0.5}) {
      soup.vertices.push_back(at + 0.2 * side * along +
                              0.2 * (side == 0.5 ? thin : 0.0) * Vec3(along.y(), -along.x(), 0.3));
    }
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  expect_answers_of_single_queries(soup, 6000);
}

TEST(PacketSearch, IsThatOfSingleQueriesOnThePelvis) {
  const auto folder = lhdl_folder();
  if (!folder) {
    GTEST_SKIP() << "the LHDL data are not here (set MUSCLEBENCH_DATA)";
  }
  expect_answers_of_single_queries(repair_mesh(read_mesh(*folder / "meshes/pelvis.ply"), "pelvis").mesh, 10000);
}

}  // namespace
}  // namespace musclebench
