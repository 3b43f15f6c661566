#include "core/effects/retinaculum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/effects/tests/effects_fixture.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

constexpr double radius_m = 0.012;
constexpr double half_width_m = 0.008;

/// A tube of 0.1 m along z in a ring about its middle.
struct Tendon : Fixture {
  Tendon() : Fixture(make_capsule(0.01, 0.05, 24)) {
    rings.push_back({.name = "ring", .axis = Vec3::UnitZ(), .radius_m = radius_m, .half_width_m = half_width_m});
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
  tendon.project(*tendon.ring_effect(), nodes);
  EXPECT_EQ(nodes.predicted, tendon.mesh.vertices);
}

/// Wherever the bone has gone, and however far the tendon has left its ring.
TEST(Retinaculum, BringsNodesBackWhereTheyAreInItsWidthAndNowhereElse) {
  Tendon tendon;
  tendon.poses[0] = RigidMotion::about_axis(Vec3(1, 2, 3).normalized(), Vec3(0.3, 0, 0.1), 1.1);
  const auto effect = tendon.ring_effect();
  for (const double away_m : {0.004, 0.5}) {
    Nodes nodes = tendon.particles();
    for (Vec3& at : nodes.predicted) at = tendon.poses[0].apply(at + Vec3(away_m, 0, 0));
    const std::vector<Vec3> before = nodes.predicted;
    tendon.project(*effect, nodes, 20);
    int moved = 0;
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      const Vec3 local = tendon.poses[0].apply_inverse(nodes.predicted[node]);
      const Vec3 was = tendon.poses[0].apply_inverse(before[node]);
      const double z = std::abs(local.z());
      const bool is_held = std::ranges::binary_search(tendon.rings[0].nodes, static_cast<int>(node));
      if (is_held && z < half_width_m) {
        EXPECT_LE(local.head<2>().norm(), radius_m + z * z / (2 * half_width_m) + 1e-9);
      }
      if (std::abs(was.z()) > half_width_m + 1e-9) {
        EXPECT_LT((local - was).norm(), 1e-15);
      }
      moved += (local - was).norm() > 1e-6 ? 1 : 0;
    }
    EXPECT_GT(moved, 20);
  }
}

/// Which has the length of its correction over the gradient of its constraint: along the inside of the ring.
TEST(Retinaculum, PushesAtRightAnglesToItsInside) {
  Tendon tendon;
  tendon.rings[0].nodes = {0};
  const auto effect = tendon.ring_effect();
  Nodes nodes = tendon.particles();
  const double z = 0.5 * half_width_m;
  const double slope = 0.5;
  nodes.predicted[0] = Vec3(0, radius_m + z * z / (2 * half_width_m) + 1e-5, z);
  const Vec3 before = nodes.predicted[0];
  tendon.project(*effect, nodes);
  const Vec3 move = nodes.predicted[0] - before;
  EXPECT_NEAR(move.norm(), 1e-5 / std::hypot(1, slope), 1e-10);
  EXPECT_NEAR(move.y() / move.z(), -1 / slope, 1e-6);
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
