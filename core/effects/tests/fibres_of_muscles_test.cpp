// Of several muscles each has fibres of its own.
#include <gtest/gtest.h>

#include "core/effects/tests/effects_fixture.hpp"

namespace musclebench {
namespace {

/// The mesh of `hinge` after so much of a stretch along x.
std::vector<Vec3> stretched(const std::vector<Vec3>& rest) {
  std::vector<Vec3> positions = rest;
  for (Vec3& position : positions) position.x() *= 1.1;
  return positions;
}

std::vector<Vec3> projected(Fixture& muscles) {
  const auto effect = muscles.make("edge_length", {{"anisotropy_exponent", 2.0}, {"stiffness", 0.5}});
  Nodes nodes = muscles.particles();
  nodes.predicted = stretched(nodes.predicted);
  muscles.project(*effect, nodes);
  return nodes.predicted;
}

TEST(FibresOfMuscles, AreThoseOfTheEdgesMuscle) {
  const TriangleMesh one = hinge(2.5);
  const std::vector<FibreSegment> along = {{Vec3(-1, 0.1, 0), Vec3(2, 0.1, 0)}};
  Fixture plain(one);
  Fixture with_fibres(one, along);
  TriangleMesh two = one;
  for (const Vec3& vertex : one.vertices) two.vertices.push_back(vertex);
  for (const auto& [a, b, c] : one.triangles) two.triangles.push_back({a + 4, b + 4, c + 4});
  Fixture both(two);
  both.bodies = {{"plain", 0, 4, 0, 2}, {"with fibres", 4, 8, 2, 4}};
  both.order = NodeOrder(both.mesh.vertices, both.bodies);
  both.fibres = {{}, along};
  const std::vector<Vec3> found = projected(both);
  const std::vector<Vec3> expected_first = projected(plain);
  const std::vector<Vec3> expected_second = projected(with_fibres);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((found[i] - expected_first[i]).norm(), 1e-14) << i;
    EXPECT_LT((found[4 + i] - expected_second[i]).norm(), 1e-14) << i;
  }
  EXPECT_GT((expected_first[0] - expected_second[0]).norm(), 1e-3) << "fibres make no difference here";
}

}  // namespace
}  // namespace musclebench
