#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/effects/tests/effects_fixture.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {
namespace {

/// A tube along z, whose fibres are, too.
Fixture fibred_tube() { return Fixture(make_capsule(0.01, 0.05, 24), {{Vec3(0, 0, -0.05), Vec3(0, 0, 0.05)}}); }

/// Between the ends of the straight part: nothing along the fibres draws at the poles.
double length_m(const Fixture& f, const std::vector<Vec3>& nodes) {
  double least = 0;
  double most = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (std::abs(f.mesh.vertices[i].z()) > 0.0501) continue;
    least = std::min(least, nodes[i].z());
    most = std::max(most, nodes[i].z());
  }
  return most - least;
}

double belly_radius_m(const Fixture& f, const std::vector<Vec3>& nodes) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (std::abs(f.mesh.vertices[i].z()) > 0.03) continue;
    sum += std::hypot(nodes[i].x(), nodes[i].y());
    ++count;
  }
  return sum / count;
}

/// Substeps of `effects` at a time, each of so many projections.
void relax(Fixture& f, Nodes& p, const std::vector<Effect*>& effects, double time_s, int projections) {
  NodeRows rows(f.order, p.predicted, p.inverse_masses);
  std::vector<NodeRow> velocities(p.size());
  const SubstepInput input{1e-3, f.poses, time_s};
  for (int i = 0; i < projections; ++i) {
    for (Effect* effect : effects) {
      effect->apply_force(rows, velocities, input, Team());
      effect->project(rows, input, Team());
    }
  }
  for (std::size_t row = 0; row < p.size(); ++row) p.predicted[f.order.node_in(row)] = rows[row].position();
}

TEST(Activation, FreeFibresShortenAndTheMuscleBulgesAtTheSameVolume) {
  Fixture f = fibred_tube();
  const auto activation = f.make("activation", {{"shortening", 0.2}, {"compliance_m_per_n", 0.0}});
  // By regions: the ends, along which no fibre draws, would take up all that the middle gives.
  const auto volume = f.make("local_volume");
  Nodes p = f.particles();
  relax(f, p, {activation.get(), volume.get()}, 10, 3000);
  EXPECT_NEAR(length_m(f, p.predicted) / length_m(f, f.mesh.vertices), 0.8, 0.02);
  EXPECT_NEAR(belly_radius_m(f, p.predicted) / 0.01, 1 / std::sqrt(0.8), 0.03);
  EXPECT_NEAR(surface_volume_m3(p.predicted, f.mesh.triangles) / surface_volume_m3(f.mesh.vertices, f.mesh.triangles),
              1, 1e-3);
}

TEST(Activation, FollowsItsCourse) {
  Fixture f = fibred_tube();
  const std::map<std::string, ParameterValue> course = {{"start_s", 1.0},
                                                        {"rise_s", 2.0},
                                                        {"hold_s", 3.0},
                                                        {"fall_s", 4.0},
                                                        {"level", 0.5},
                                                        {"shortening", 0.4},
                                                        {"compliance_m_per_n", 0.0}};
  // Half of the shortening at most.
  for (const auto& [time_s, wanted] :
       {std::pair(0.5, 1.0), {1.0, 1.0}, {2.0, 0.9}, {3.0, 0.8}, {5.9, 0.8}, {8.0, 0.9}, {10.0, 1.0}, {100.0, 1.0}}) {
    const auto activation = f.make("activation", course);
    Nodes p = f.particles();
    relax(f, p, {activation.get()}, time_s, 2000);
    EXPECT_NEAR(length_m(f, p.predicted) / length_m(f, f.mesh.vertices), wanted, 0.02) << time_s;
  }
}

TEST(Activation, AMuscleTakesItsShareOfIt) {
  for (const auto& [share, wanted] : {std::pair(0.0, 1.0), {0.5, 0.8}, {1.0, 0.6}}) {
    Fixture f = fibred_tube();
    f.bodies[0].activation = share;
    const auto activation = f.make("activation", {{"shortening", 0.4}, {"compliance_m_per_n", 0.0}});
    Nodes p = f.particles();
    relax(f, p, {activation.get()}, 10, 2000);
    EXPECT_NEAR(length_m(f, p.predicted) / length_m(f, f.mesh.vertices), wanted, 0.03) << share;
  }
}

/// Both ends are held: it cannot shorten, and pulls them with all that its compliance allows.
TEST(Activation, IsometricKeepsItsLengthAndPullsAtItsEnds) {
  Fixture f = fibred_tube();
  const auto activation = f.make("activation", {{"compliance_m_per_n", 0.0}});
  Nodes p = f.particles();
  int held = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (std::abs(f.mesh.vertices[i].z()) < 0.05) continue;
    p.inverse_masses[i] = 0;
    ++held;
  }
  ASSERT_GT(held, 10);
  relax(f, p, {activation.get()}, 10, 500);
  EXPECT_EQ(length_m(f, p.predicted), length_m(f, f.mesh.vertices));
  for (const Vec3& x : p.predicted) ASSERT_TRUE(x.allFinite());
  // Released, it shortens.
  p.inverse_masses.assign(p.size(), 1.0);
  relax(f, p, {activation.get()}, 10, 3000);
  EXPECT_NEAR(length_m(f, p.predicted) / length_m(f, f.mesh.vertices), 0.8, 0.02);
}

/// Two triangles of the same size; one edge of each lies along the fibres, or 30 degrees off, and the others lie
/// across.
TEST(Activation, AnEdgeOffTheFibresYieldsMore) {
  const double angle_rad = std::numbers::pi / 6;
  const Vec3 off(0.1 * std::sin(angle_rad), 0, 0.1 * std::cos(angle_rad));
  TriangleMesh mesh;
  for (const auto& [at, edge] : {std::pair(Vec3(0, 0, 0), Vec3(0, 0, 0.1)), {Vec3(1, 0, 0), off}}) {
    const auto first = static_cast<int>(mesh.vertices.size());
    for (const Vec3& corner : {Vec3(0, 0, 0), edge, Vec3(0.5 * edge + Vec3(0, 0.3, 0))}) {
      mesh.vertices.push_back(at + corner);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  Fixture f(mesh, {{Vec3(0, 0, -0.05), Vec3(0, 0, 0.2)}, {Vec3(1, 0, -0.05), Vec3(1, 0, 0.2)}});
  const double shortening = 0.2;
  const auto activation = f.make("activation", {{"shortening", shortening}, {"compliance_m_per_n", 0.005}});
  Nodes p = f.particles();
  relax(f, p, {activation.get()}, 10, 2);  // the first tells the length to the second
  const auto shortened_m = [&](std::size_t first) {
    return (mesh.vertices[first + 1] - mesh.vertices[first]).norm() -
           (p.predicted[first + 1] - p.predicted[first]).norm();
  };
  const double cosine = std::cos(angle_rad);
  const double wanted_m =
      0.1 * std::sqrt(std::pow((1 - shortening) * cosine, 2) + (1 - cosine * cosine) / (1 - shortening));
  // Each moves by its gap over its compliance, far beyond which the nodes' own weights are.
  ASSERT_GT(shortened_m(0), 1e-9);
  EXPECT_NEAR(shortened_m(3) / shortened_m(0), cosine * (0.1 - wanted_m) / (0.1 * shortening), 1e-3);
}

TEST(Activation, WithoutFibresOrBeforeItsStartMovesNothing) {
  Fixture bare(make_capsule(0.01, 0.05, 24));
  const auto without = bare.make("activation");
  Nodes p = bare.particles();
  relax(bare, p, {without.get()}, 10, 3);
  EXPECT_EQ(p.predicted, bare.mesh.vertices);

  Fixture f = fibred_tube();
  const auto later = f.make("activation", {{"start_s", 1.0}});
  Nodes q = f.particles();
  relax(f, q, {later.get()}, 0.5, 3);
  for (std::size_t i = 0; i < q.size(); ++i) ASSERT_LT((q.predicted[i] - f.mesh.vertices[i]).norm(), 1e-15);
}

}  // namespace
}  // namespace musclebench
