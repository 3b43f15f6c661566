#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/effects/tests/effects_fixture.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

constexpr double clearance_m = 0.002;
constexpr double half_width_m = 0.008;

/// A tube of 0.1 m along z in a ring about its middle.
struct Tendon : Fixture {
  Tendon() : Fixture(make_capsule(0.01, 0.05, 24)) {
    rings.push_back({.name = "ring",
                     .axis = Vec3::UnitZ(),
                     .radius_m = 0.012,
                     .half_width_m = half_width_m,
                     .clearance_m = clearance_m});
    rings[0].nodes = nodes_through_ring(mesh, bodies[0], rings[0], 0.02);
  }

  std::unique_ptr<Effect> ring_effect() {
    const EffectEntry* entry = find_effect("retinaculum");
    return entry->make({mesh, bodies, order, fibres, bound, poses, ends, rings}, Parameters(entry->parameters, {}, ""));
  }

  std::vector<Retinaculum> rings;
};

TEST(Retinaculum, NodesInTheRingAreThereAndThoseThatMaySlideIntoIt) {
  const Tendon tendon;
  for (int node = 0; node < static_cast<int>(tendon.mesh.vertices.size()); ++node) {
    const double z = std::abs(tendon.mesh.vertices[static_cast<std::size_t>(node)].z());
    const bool is_in = std::ranges::binary_search(tendon.rings[0].nodes, node);
    if (z < 0.011) {
      EXPECT_TRUE(is_in) << z;
    }
    if (z > 0.05) {
      EXPECT_FALSE(is_in) << z;
    }
  }
  Retinaculum elsewhere = tendon.rings[0];
  elsewhere.centre_m = Vec3(0.05, 0, 0);
  EXPECT_TRUE(nodes_through_ring(tendon.mesh, tendon.bodies[0], elsewhere, 0.02).empty());
}

TEST(Retinaculum, LeavesATendonAloneThatIsInItsRing) {
  Tendon tendon;
  Nodes nodes = tendon.particles();
  for (Vec3& at : nodes.predicted) at.x() += 0.99 * clearance_m;
  const std::vector<Vec3> before = nodes.predicted;
  tendon.project(*tendon.ring_effect(), nodes);
  EXPECT_EQ(nodes.predicted, before);
}

/// Wherever the bone has gone, and however far the tendon has left its ring.
TEST(Retinaculum, BringsTheTendonBackInItsWidthAndKeepsItsSections) {
  Tendon tendon;
  tendon.poses[0] = RigidMotion::about_axis(Vec3(1, 2, 3).normalized(), Vec3(0.3, 0, 0.1), 1.1);
  const auto effect = tendon.ring_effect();
  for (const double away_m : {0.004, 0.5}) {
    Nodes nodes = tendon.particles();
    for (Vec3& at : nodes.predicted) at = tendon.poses[0].apply(at + Vec3(away_m, 0, 0));
    tendon.project(*effect, nodes);
    const std::vector<Vec3> once = nodes.predicted;
    tendon.project(*effect, nodes);
    double largest_m = 0;
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      EXPECT_LT((nodes.predicted[node] - once[node]).norm(), 1e-12) << "it is there after one correction";
      const Vec3& rest = tendon.mesh.vertices[node];
      const Vec3 moved_m = tendon.poses[0].apply_inverse(nodes.predicted[node]) - rest - Vec3(away_m, 0, 0);
      EXPECT_NEAR(moved_m.tail<2>().norm(), 0, 1e-12);
      EXPECT_LE(moved_m.x(), 1e-12);
      if (std::abs(rest.z()) > half_width_m) {
        EXPECT_NEAR(moved_m.norm(), 0, 1e-12);
      }
      largest_m = std::max(largest_m, -moved_m.x());
    }
    EXPECT_GE(largest_m, away_m - clearance_m);
    EXPECT_LT(largest_m, 2 * (away_m - clearance_m));
  }
}

/// Nodes that a bone carries have a part in the middle: a tendon that is half bound in its ring is in it.
TEST(Retinaculum, LeavesATendonAloneThatIsHalfBoundInItsRing) {
  Tendon tendon;
  tendon.rings[0].clearance_m = 5e-4;
  Nodes nodes = tendon.particles();
  for (std::size_t node = 0; node < nodes.size(); ++node) {
    if (nodes.predicted[node].x() > 0) nodes.inverse_masses[node] = 0;
  }
  tendon.project(*tendon.ring_effect(), nodes);
  EXPECT_EQ(nodes.predicted, tendon.mesh.vertices);
  for (Vec3& at : nodes.predicted) at.x() += 0.003;
  tendon.project(*tendon.ring_effect(), nodes);
  for (std::size_t node = 0; node < nodes.size(); ++node) {
    const double moved_m = nodes.predicted[node].x() - tendon.mesh.vertices[node].x() - 0.003;
    if (nodes.inverse_masses[node] == 0) {
      EXPECT_EQ(nodes.predicted[node].x(), tendon.mesh.vertices[node].x() + 0.003);
    } else {
      EXPECT_LE(moved_m, 1e-15);
    }
  }
}

/// A node that stands for a larger area counts for more: the middle does not depend on where a mesh is fine.
TEST(Retinaculum, LooksAtAreasAndNotAtNodes) {
  Tendon tendon;
  std::vector<Triangle> finer;
  for (const Triangle& triangle : tendon.mesh.triangles) {  // those at x > 0 are split in three
    Vec3 centre = Vec3::Zero();
    for (const int node : triangle) centre += tendon.mesh.vertices[static_cast<std::size_t>(node)] / 3;
    if (centre.x() < 0) {
      finer.push_back(triangle);
      continue;
    }
    const int middle = static_cast<int>(tendon.mesh.vertices.size());
    tendon.mesh.vertices.push_back(centre);
    for (std::size_t k = 0; k < 3; ++k) finer.push_back({triangle[k], triangle[(k + 1) % 3], middle});
  }
  Tendon fine;
  static_cast<Fixture&>(fine) = Fixture(TriangleMesh{tendon.mesh.vertices, finer});
  fine.rings[0].nodes = nodes_through_ring(fine.mesh, fine.bodies[0], fine.rings[0], 0.02);
  fine.rings[0].clearance_m = 2e-4;
  Nodes nodes = fine.particles();
  fine.project(*fine.ring_effect(), nodes);
  for (std::size_t node = 0; node < nodes.size(); ++node) {
    EXPECT_LT((nodes.predicted[node] - fine.mesh.vertices[node]).norm(), 2e-4);
  }
}

TEST(Retinaculum, TellsMassTimesCorrectionAndMovesNoBoundNode) {
  Tendon tendon;
  const auto effect = tendon.ring_effect();
  std::vector<double> inverse_masses(tendon.mesh.vertices.size(), 1 / 0.002);
  std::vector<Vec3> away = tendon.mesh.vertices;
  for (Vec3& at : away) at.x() += 0.004;
  const auto bound = static_cast<std::size_t>(tendon.rings[0].nodes[3]);
  inverse_masses[bound] = 0;
  NodeRows rows(tendon.order, away, inverse_masses);
  std::vector<NodeRow> impulses(rows.size() + 1);
  rows.set_impulses(impulses.data());
  effect->project(rows, {1e-3, tendon.poses}, Team());
  double largest = 0;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const auto node = static_cast<std::size_t>(tendon.order.node_in(row));
    const Vec3 moved = rows[row].position() - away[node];
    EXPECT_LT((impulses[row].position() - 0.002 * moved).norm(), 1e-15);
    if (node == bound) {
      EXPECT_EQ(moved.norm(), 0);
    }
    largest = std::max(largest, moved.norm());
  }
  EXPECT_GT(largest, 1e-4);
}

}  // namespace
}  // namespace musclebench
