#include "core/effects/fixed_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/effects/bending/bending.hpp"
#include "core/effects/edge_length/edge_length.hpp"
#include "core/effects/tests/effects_fixture.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// Bound are the nodes of a ball above z = 0.4 by one bone, those below -0.6 by another.
std::vector<BoundNode> bound_caps(const TriangleMesh& ball) {
  std::vector<BoundNode> bound;
  for (int node = 0; node < static_cast<int>(ball.vertices.size()); ++node) {
    const double z = ball.vertices[static_cast<std::size_t>(node)].z();
    if (z > 0.4 || z < -0.6) bound.push_back({node, z > 0 ? 0 : 1});
  }
  return bound;
}

/// Positions after projections of a ball that was pressed, whose caps do not move; the effect knows of that or not.
std::vector<Vec3> projected(const std::string& effect, const std::map<std::string, ParameterValue>& given, bool knows) {
  const TriangleMesh ball = make_sphere(1, 3);
  const std::vector<BoundNode> bound = bound_caps(ball);
  Fixture f(ball, {}, knows ? bound : std::vector<BoundNode>{});
  const auto made = f.make(effect, given);
  Nodes p = f.particles();
  for (const BoundNode& node : bound) p.inverse_masses[static_cast<std::size_t>(node.node)] = 0;
  for (Vec3& position : p.predicted) position.z() *= 0.8 + 0.1 * std::abs(position.x());
  f.project(*made, p, 5);
  return p.predicted;
}

TEST(FixedNodes, LeavingOutTheirConstraintsChangesNoBit) {
  const std::map<std::string, std::vector<std::map<std::string, ParameterValue>>> settings = {
      {"edge_length", {{}, {{"compliance_m_per_n", 1e-4}}, {{"visits_per_edge", std::int64_t{2}}}}},
      {"bending", {{}, {{"compliance_rad_per_n_m", 1e-2}}, {{"public_code_ratio_gate", true}}}}};
  for (const auto& [effect, all] : settings) {
    for (const auto& given : all) EXPECT_EQ(projected(effect, given, true), projected(effect, given, false)) << effect;
  }
}

TEST(FixedNodes, HaveNoConstraintsAmongEachOther) {
  const TriangleMesh ball = make_sphere(1, 3);
  Fixture free(ball);
  Fixture bound(ball, {}, bound_caps(ball));
  const auto input = [](Fixture& f) { return EffectInput{f.mesh, f.bodies, f.order, f.fibres, f.bound, f.poses}; };
  const Parameters of_edges(find_effect("edge_length")->parameters, {}, "test");
  const Parameters of_bending(find_effect("bending")->parameters, {}, "test");
  const FixedNodes fixed(input(bound));
  std::size_t edges = 0;
  for (const LengthConstraint& each : edge_length_constraints(input(free), of_edges)) {
    edges += fixed.are_all(each.nodes) ? 0 : 1;
  }
  std::size_t angles = 0;
  for (const AngleConstraint& each : bending_constraints(input(free), of_bending)) {
    angles += fixed.are_all(each.nodes) ? 0 : 1;
  }
  EXPECT_EQ(edge_length_constraints(input(bound), of_edges).size(), edges);
  EXPECT_EQ(bending_constraints(input(bound), of_bending).size(), angles);
  EXPECT_LT(edges, edge_length_constraints(input(free), of_edges).size() * 3 / 4);
  EXPECT_LT(angles, bending_constraints(input(free), of_bending).size() * 3 / 4);
}

/// An octahedron whose triangles differ in size by a thousand times.
TEST(Bending, ConstrainsEveryEdgeWhateverItsTriangles) {
  const TriangleMesh mesh = {{{1, 0, 0}, {0, 3, 0}, {-10, 0, 0}, {0, -0.1, 0}, {0, 0, 0.5}, {0, 0, -20}},
                             {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}}};
  Fixture f(mesh);
  std::set<std::pair<int, int>> edges;
  const Parameters parameters(find_effect("bending")->parameters, {}, "test");
  for (const AngleConstraint& each :
       bending_constraints({f.mesh, f.bodies, f.order, f.fibres, f.bound, f.poses}, parameters)) {
    edges.insert(std::minmax(each.nodes[0], each.nodes[1]));
  }
  EXPECT_EQ(edges.size(), 12U);
}

}  // namespace
}  // namespace musclebench
