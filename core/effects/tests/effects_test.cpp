#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "core/effects/effect_registry.hpp"
#include "core/effects/surface_edges.hpp"
#include "core/effects/tests/effects_fixture.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {
namespace {

TriangleMesh one_triangle(double height_m) { return {{{0, 0, 0}, {1, 0, 0}, {0, height_m, 0}}, {{0, 1, 2}}}; }

TEST(Bending, OneFullProjectionRestoresTheAngleInBothDirections) {
  for (const double rest : {0.0, 0.4, -0.4, 1.5, -2.5}) {
    for (const double change : {1e-3, -1e-3}) {
      Fixture f(hinge(rest));
      const auto bending = f.make("bending", {{"stiffness", 1.0}});
      Nodes p = f.particles();
      const double wanted = hinge_angle(p.predicted);
      p.predicted = hinge(rest + change).vertices;
      const double before = std::abs(std::remainder(hinge_angle(p.predicted) - wanted, 2 * M_PI));
      ASSERT_NEAR(before, 1e-3, 1e-9);
      f.project(*bending, p);
      EXPECT_LT(std::abs(std::remainder(hinge_angle(p.predicted) - wanted, 2 * M_PI)), 1e-5) << rest << " " << change;
    }
  }
}

TEST(Bending, KeepsLinearAndAngularMomentum) {
  Fixture f(hinge(0.3));
  const auto bending = f.make("bending");
  Nodes p = f.particles();
  p.inverse_masses = {1.0, 0.5, 2.0, 0.01};
  const std::vector<Vec3> before = hinge(0.8).vertices;
  p.predicted = before;
  f.project(*bending, p);
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
  double scale = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 momentum = (p.predicted[i] - before[i]) / p.inverse_masses[i];
    linear += momentum;
    angular += before[i].cross(momentum);
    scale += momentum.norm();
  }
  EXPECT_GT(scale, 1e-3);
  EXPECT_LT(linear.norm(), 1e-12 * scale);
  EXPECT_LT(angular.norm(), 1e-12 * scale);
}

TEST(Bending, RatioGateActsInOneDirectionOnly) {
  Fixture f(hinge(0.4));
  const auto gated = f.make("bending", {{"public_code_ratio_gate", true}});
  const double rest = hinge_angle(f.mesh.vertices);
  int moved = 0;
  for (const double change : {0.2, -0.2}) {
    Nodes p = f.particles();
    p.predicted = hinge(0.4 + change).vertices;
    const double before = hinge_angle(p.predicted) - rest;
    f.project(*gated, p);
    moved += std::abs(hinge_angle(p.predicted) - rest) < 0.5 * std::abs(before) ? 1 : 0;
  }
  EXPECT_EQ(moved, 1);
}

TEST(Bending, RatioGateLeavesPairsThatAreFlatAtRest) {
  Fixture f(hinge(0));
  const auto gated = f.make("bending", {{"public_code_ratio_gate", true}});
  Nodes p = f.particles();
  p.predicted = hinge(0.5).vertices;
  const auto before = p.predicted;
  f.project(*gated, p);
  EXPECT_EQ(p.predicted, before);
}

TEST(Bending, RatioGateIsOpenFromATenthToTenTimesTheRestAngle) {
  constexpr double rest_rad = 0.2;
  for (const auto& [ratio, is_open] : {std::pair(0.09, false), {0.11, true}, {1.0, true}, {9.9, true}, {10.1, false}}) {
    Fixture f(hinge(rest_rad));
    const auto gated = f.make("bending", {{"public_code_ratio_gate", true}});
    Nodes p = f.particles();
    p.predicted = hinge(rest_rad + ratio * rest_rad).vertices;
    const auto before = p.predicted;
    f.project(*gated, p);
    EXPECT_EQ(p.predicted != before, is_open) << ratio;
  }
}

TEST(Bending, LeavesOutPairsThatAreFlatterThanTold) {
  for (const double rest_rad : {0.19, -0.19, 0.21, -0.21, 2.5}) {
    Fixture f(hinge(rest_rad));
    const auto bending = f.make("bending", {{"skip_flatter_than_rad", 0.2}});
    Nodes p = f.particles();
    p.predicted = hinge(rest_rad + 0.3).vertices;
    const auto before = p.predicted;
    f.project(*bending, p);
    EXPECT_EQ(p.predicted != before, std::abs(rest_rad) > 0.2) << rest_rad;
  }
}

TEST(Bending, DegenerateTriangleChangesNothing) {
  Fixture f(hinge(0.4));
  const auto bending = f.make("bending");
  Nodes p = f.particles();
  p.predicted[2] = Vec3(0.5, 0, 0);
  const auto before = p.predicted;
  f.project(*bending, p);
  EXPECT_EQ(p.predicted, before);
}

TEST(EdgeLength, OneEdgeIsRestoredByMassRatio) {
  Fixture f(one_triangle(1));
  const auto length = f.make("edge_length");
  Nodes p = f.particles();
  p.inverse_masses = {0.0, 1.0, 0.0};
  p.predicted[1] = Vec3(2, 0, 0);
  p.predicted[2] = Vec3(0, 1, 0);
  f.project(*length, p, 200);
  EXPECT_NEAR((p.predicted[1] - p.predicted[0]).norm(), 1.0, 1e-9);
  EXPECT_NEAR((p.predicted[1] - p.predicted[2]).norm(), std::sqrt(2.0), 1e-9);
  EXPECT_EQ(p.predicted[0], f.mesh.vertices[0]);
}

TEST(EdgeLength, CollapsedEdgeStaysFinite) {
  Fixture f(make_sphere(1, 1));
  const auto length = f.make("edge_length");
  Nodes p = f.particles();
  for (Vec3& x : p.predicted) {
    x.setZero();
  }
  f.project(*length, p);
  for (const Vec3& x : p.predicted) {
    EXPECT_TRUE(x.allFinite());
  }
}

TEST(EdgeLength, IsSoftAlongFibresOnly) {
  Fixture f(one_triangle(1), {{Vec3(-5, 0, 0), Vec3(5, 0, 0)}});
  const auto length = f.make("edge_length");
  Nodes p = f.particles();
  p.inverse_masses = {0.0, 1.0, 0.0};
  p.predicted[1] = Vec3(1.5, 0, 0);  // the edge 0-1 runs along the fibre: only the oblique edge 1-2 pulls
  f.project(*length, p);
  const double k = std::sqrt(1 - std::sqrt(0.5));
  const double oblique = std::hypot(1.5, 1.0);
  EXPECT_NEAR((p.predicted[1] - p.predicted[2]).norm(), oblique - k * (oblique - std::sqrt(2.0)), 1e-12);
}

TEST(EdgeLength, TwoVisitsCorrectMoreThanOne) {
  Fixture f(one_triangle(9));
  Nodes once = f.particles();
  once.inverse_masses = {0.0, 1.0, 0.0};
  once.predicted[1] = Vec3(2, 0, 0);
  Nodes twice = once;
  f.project(*f.make("edge_length", {{"stiffness", 0.5}}), once);
  f.project(*f.make("edge_length", {{"stiffness", 0.5}, {"visits_per_edge", std::int64_t{2}}}), twice);
  EXPECT_GT(once.predicted[1].x(), twice.predicted[1].x() + 0.1);
}

TEST(Volume, FullProjectionRestoresTheVolume) {
  Fixture f(make_sphere(0.05, 3));
  for (Vec3& x : f.mesh.vertices) {
    x += Vec3(1000, 0, 0);
  }
  const auto volume = f.make("volume");
  Nodes p = f.particles();
  const double rest = surface_volume_m3(p.predicted, f.mesh.triangles);
  for (Vec3& x : p.predicted) {
    x.z() *= 0.8;
  }
  f.project(*volume, p, 3);
  EXPECT_NEAR(surface_volume_m3(p.predicted, f.mesh.triangles) / rest, 1.0, 1e-6);
}

TEST(Volume, ScaledProjectionCorrectsItsPart) {
  Fixture f(make_sphere(0.05, 3));
  const auto volume = f.make("volume", {{"pressure", 1.01}, {"projection_scale", 1.0 / 6}});
  Nodes p = f.particles();
  const double rest = surface_volume_m3(p.predicted, f.mesh.triangles);
  f.project(*volume, p);
  EXPECT_NEAR(surface_volume_m3(p.predicted, f.mesh.triangles) / rest, 1 + 0.01 / 6, 1e-5);
}

/// Heavy nodes move less, and the volume is restored all the same.
TEST(Volume, MassesShareTheCorrection) {
  Fixture f(make_sphere(0.05, 2));
  const auto volume = f.make("volume", {{"pressure", 1.01}});
  Nodes p = f.particles();
  for (std::size_t i = 0; i < p.size(); ++i) {
    p.inverse_masses[i] = i % 2 == 0 ? 0.1 : 3;
  }
  const double rest = surface_volume_m3(p.predicted, f.mesh.triangles);
  f.project(*volume, p);
  EXPECT_NEAR(surface_volume_m3(p.predicted, f.mesh.triangles) / rest, 1.01, 2e-4);
}

TEST(Volume, BoundNodesDoNotMove) {
  Fixture f(make_sphere(0.05, 2));
  const auto volume = f.make("volume", {{"pressure", 1.5}});
  Nodes p = f.particles();
  p.inverse_masses[7] = 0;
  f.project(*volume, p);
  EXPECT_EQ(p.predicted[7], f.mesh.vertices[7]);
  EXPECT_NE(p.predicted[8], f.mesh.vertices[8]);
}

TEST(Attachment, BoundNodesMoveRigidlyWithTheirBoneToTheBit) {
  for (const RigidMotion& rest :
       {RigidMotion{}, RigidMotion::about_axis(Vec3(1, 2, 3).normalized(), Vec3(0.01, 0, 0.02), 0.3)}) {
    const std::vector<BoundNode> bound = {{3, 0}, {8, 0}, {11, 0}};
    Fixture f(make_sphere(0.05, 1), {}, bound);
    f.poses[0] = rest;
    const auto attachment = f.make("attachment");
    Nodes p = f.particles();
    for (int step = 1; step <= 100; ++step) {
      f.poses[0] = RigidMotion::about_axis(Vec3(2, -1, 1).normalized(), Vec3(0, 0.02, 0), 0.05 * step) * rest;
      f.project(*attachment, p);
      for (const BoundNode& node : bound) {
        const Vec3 at_rest = rest.apply_inverse(f.mesh.vertices[node.node]);
        EXPECT_EQ(p.predicted[node.node], f.poses[0].apply(at_rest)) << "node " << node.node << ", step " << step;
      }
    }
    EXPECT_EQ(p.predicted[4], f.mesh.vertices[4]);
  }
}

TEST(Gravity, AcceleratesFreeNodesOnly) {
  Fixture f(make_sphere(0.05, 1));
  const auto gravity = f.make("gravity");
  Nodes p = f.particles();
  p.inverse_masses[2] = 0;
  f.apply_force(*gravity, p, 0.1);
  EXPECT_NEAR(p.velocities[1].z(), -0.980665, 1e-15);
  EXPECT_EQ(p.velocities[2], Vec3(0, 0, 0));
}

TEST(SurfaceEdges, EveryEdgeOnceAndBothSidesKnown) {
  const TriangleMesh mesh = make_sphere(1, 3);
  const auto edges = surface_edges(mesh);
  EXPECT_EQ(edges.size(), mesh.triangles.size() * 3 / 2);
  for (const SurfaceEdge& edge : edges) {
    EXPECT_GE(edge.left, 0);
    EXPECT_GE(edge.right, 0);
  }
}

/// Corrections that follow each other do not wait for one another: only where one group of edges ends and the next
/// begins may two in a row share a vertex.
TEST(SurfaceEdges, NoTwoInARowShareAVertexButBetweenGroups) {
  const auto edges = surface_edges(make_sphere(1, 4));
  int sharing = 0;
  for (std::size_t i = 1; i < edges.size(); ++i) {
    const SurfaceEdge& one = edges[i - 1];
    const std::set<int> corners = {one.start, one.end, one.left, one.right};
    const SurfaceEdge& other = edges[i];
    sharing += corners.contains(other.start) || corners.contains(other.end) || corners.contains(other.left) ||
                       corners.contains(other.right)
                   ? 1
                   : 0;
  }
  EXPECT_LT(sharing, 64);
}

TEST(Registry, NamesAreThoseOfTheEffects) {
  Fixture f(make_sphere(1, 1));
  for (const EffectEntry& entry : effect_registry()) {
    if (entry.make) {
      EXPECT_EQ(f.make(entry.name)->name(), entry.name);
    }
  }
  EXPECT_EQ(find_effect("nonsense"), nullptr);
}

}  // namespace
}  // namespace musclebench
