#include "core/effects/fibre_force/fibre_force.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include "core/constraints/fibre_constraints.hpp"
#include "core/effects/tests/effects_fixture.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {
namespace {

constexpr double time_step_s = 2e-4;

/// A closed tube of 0.1 m along z, whose round ends bones carry.
struct Muscle : Fixture {
  Muscle() : Fixture(make_capsule(0.01, 0.05, 24)) {
    ends.resize(1);
    for (int i = 0; i < static_cast<int>(mesh.vertices.size()); ++i) {
      const double z = mesh.vertices[static_cast<std::size_t>(i)].z();
      if (std::abs(z) < 0.0499) continue;
      (z < 0 ? ends[0].origin : ends[0].insertion).push_back(i);
      bound.push_back({i, 0});
    }
  }
  /// Their mean length: the ends take in evenly over half a sphere each.
  double fibres_m = 0.1 + 2 * 0.01 * mean_angle_to_rim;
  static constexpr double mean_angle_to_rim = std::numbers::pi / 2 - 1;  // of a half sphere, by area

  [[nodiscard]] NodeRows rows(double mass_kg = 1e-4) const {
    std::vector<double> inverse_masses(mesh.vertices.size(), 1 / mass_kg);
    for (const BoundNode& node : bound) inverse_masses[static_cast<std::size_t>(node.node)] = 0;
    return {order, mesh.vertices, inverse_masses};
  }
  /// The force on the origin's nodes in one substep, of whose start the nodes have these places.
  Vec3 pull_on_origin_n(Effect& effect, NodeRows at) {
    std::vector<NodeRow> impulses(at.size() + 1);
    at.set_impulses(impulses.data());
    effect.apply_force(at, {}, {time_step_s, poses, 1}, Team());
    effect.project(at, {time_step_s, poses, 1}, Team());
    Vec3 sum = Vec3::Zero();
    for (const int node : ends[0].origin) sum += impulses[static_cast<std::size_t>(order.row_of(node))].position();
    return sum / (time_step_s * time_step_s);
  }
};

/// The stress on the cross-section, all of which fibres of equal length pull with.
TEST(FibreForce, OfATubeIsTheStressTimesItsCrossSection) {
  Muscle muscle;
  const double section_m2 = surface_volume_m3(muscle.mesh.vertices, muscle.mesh.triangles) / muscle.fibres_m;
  for (const double level : {1.0, 0.05}) {
    const auto effect = muscle.make("fibre_force", {{"level", level}, {"rise_s", 0.0}});
    const Vec3 pull_n = muscle.pull_on_origin_n(*effect, muscle.rows());
    EXPECT_NEAR(pull_n.z(), level * 3e5 * section_m2, 0.02 * pull_n.z());
    EXPECT_NEAR(pull_n.head<2>().norm(), 0, 1e-3 * pull_n.z());
    EXPECT_NEAR(effect->fibre_impulses_n_s().at(0), pull_n.z() * time_step_s, 0.01 * pull_n.z() * time_step_s);
  }
}

/// Nothing else holds the nodes between the ends: they stay where they are, since the pulls on them are balanced.
TEST(FibreForce, OfATubeAtRestMovesNoNodeAlongIt) {
  Muscle muscle;
  const auto effect = muscle.make("fibre_force", {{"rise_s", 0.0}});
  NodeRows rows = muscle.rows();
  effect->apply_force(rows, {}, {time_step_s, muscle.poses, 1}, Team());
  effect->project(rows, {time_step_s, muscle.poses, 1}, Team());
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const Vec3& rest = muscle.mesh.vertices[static_cast<std::size_t>(muscle.order.node_in(row))];
    EXPECT_NEAR(rows[row].position().z(), rest.z(), 1e-7);
  }
}

TEST(FibreForce, HoldsAStretchedTubeWithoutActivation) {
  Muscle muscle;
  const double section_m2 = surface_volume_m3(muscle.mesh.vertices, muscle.mesh.triangles) / muscle.fibres_m;
  const auto effect = muscle.make("fibre_force", {{"level", 0.0}, {"passive_strain", 0.3}});
  NodeRows rows = muscle.rows();
  for (std::size_t row = 0; row < rows.size(); ++row) {
    rows[row].z *= 1.2;
    rows[row].inverse_mass = 0;
  }
  // Thelen 2003, equation 3.
  const double passive = (std::exp(5 * 0.2 / 0.3) - 1) / (std::exp(5) - 1);
  const Vec3 pull_n = muscle.pull_on_origin_n(*effect, rows);
  EXPECT_NEAR(pull_n.z(), passive * 3e5 * section_m2, 0.02 * pull_n.z());
  const auto slack = muscle.make("fibre_force", {{"level", 0.0}});
  EXPECT_LT(muscle.pull_on_origin_n(*slack, muscle.rows()).norm(), 1e-12);
}

/// A mass on active fibres, which nothing holds else: it moves as one on a Hill muscle does, which pulls less the
/// faster it shortens, integrated in small steps.
TEST(FibreForce, ShortensAsFastAsItsLoadLets) {
  constexpr double mass_kg = 2;
  Muscle muscle;
  const double section_m2 = surface_volume_m3(muscle.mesh.vertices, muscle.mesh.triangles) / muscle.fibres_m;
  const auto effect = muscle.make("fibre_force", {{"rise_s", 0.0}});
  NodeRows start = muscle.rows();
  std::vector<double> speeds(start.size(), 0.0);
  // Every node between the ends follows in proportion: the tube has the mass at its end only.
  double end_m = 0, speed_m_per_s = 0;
  double hill_m = 0, hill_m_per_s = 0;
  for (int step = 0; step < 300; ++step) {
    NodeRows rows = start;
    for (std::size_t row = 0; row < rows.size(); ++row) {
      rows[row].inverse_mass = 0;
      rows[row].z = start[row].z + end_m * std::clamp((start[row].z + 0.05) / 0.1, 0.0, 1.0);
    }
    const double pull_n = muscle.pull_on_origin_n(*effect, rows).z();
    speed_m_per_s -= time_step_s * pull_n / mass_kg;
    end_m += time_step_s * speed_m_per_s;
    for (int part = 0; part < 20; ++part) {
      const double stretch = 1 + hill_m / 0.1;
      const double force_n = 3e5 * section_m2 * std::exp(-(stretch - 1) * (stretch - 1) / 0.45) *
                             FibreLaw::active_over_speed(hill_m_per_s / (0.1 * 10));
      hill_m_per_s -= time_step_s / 20 * force_n / mass_kg;
      hill_m += time_step_s / 20 * hill_m_per_s;
    }
  }
  EXPECT_LT(hill_m, -0.02);
  EXPECT_NEAR(end_m, hill_m, 0.02 * std::abs(hill_m));
}

TEST(FibreForce, HasNoFibresWithoutTwoEndsOrAClosedSurface) {
  Muscle one_end;
  one_end.ends[0].insertion.clear();
  const auto effect = one_end.make("fibre_force", {{"rise_s", 0.0}});
  EXPECT_EQ(one_end.pull_on_origin_n(*effect, one_end.rows()), Vec3::Zero());
  EXPECT_EQ(effect->fibre_impulses_n_s(), std::vector<double>{0.0});
  Muscle inside_out;
  for (Triangle& triangle : inside_out.mesh.triangles) std::swap(triangle[0], triangle[1]);
  const auto other = inside_out.make("fibre_force", {{"rise_s", 0.0}});
  EXPECT_EQ(inside_out.pull_on_origin_n(*other, inside_out.rows()), Vec3::Zero());
  Muscle open;
  open.mesh.triangles.erase(open.mesh.triangles.begin() + 200);
  --open.bodies[0].last_triangle;
  const auto none = open.make("fibre_force", {{"rise_s", 0.0}});
  EXPECT_EQ(open.pull_on_origin_n(*none, open.rows()), Vec3::Zero());
}

/// Three substeps of two projections, from disturbed places.
std::vector<Vec3> moved_by(Muscle& muscle, int threads) {
  const auto effect = muscle.make("fibre_force", {{"rise_s", 0.0}, {"passive_strain", 0.2}});
  NodeRows rows = muscle.rows();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-0.002, 0.002);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    rows[row].set_position(rows[row].position() + Vec3(unit(random), unit(random), unit(random)));
  }
  std::vector<NodeRow> impulses(rows.size() + 1);
  rows.set_impulses(impulses.data());
  Barrier barrier(threads);
  std::vector<std::thread> team;
  for (int thread = 0; thread < threads; ++thread) {
    team.emplace_back([&, thread] {
      const Team member(thread, threads, barrier);
      const SubstepInput input{time_step_s, muscle.poses, 1};
      for (int substep = 0; substep < 3; ++substep) {
        effect->apply_force(rows, {}, input, member);
        member.wait();
        for (int iteration = 0; iteration < 2; ++iteration) {
          effect->project(rows, input, member);
          member.wait();
        }
      }
    });
  }
  for (std::thread& thread : team) thread.join();
  std::vector<Vec3> found;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    found.push_back(rows[row].position());
    found.push_back(impulses[row].position());
  }
  found.emplace_back(effect->fibre_impulses_n_s().at(0), 0, 0);
  return found;
}

TEST(FibreForce, NeitherThreadsNorProcessorsChangeABit) {
  Muscle muscle;
  const std::vector<Vec3> expected = moved_by(muscle, 1);
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    for (const int threads : {1, 2, 3}) {
      EXPECT_EQ(moved_by(muscle, threads), expected) << hwy::TargetName(target) << ", " << threads;
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

/// What moves the free nodes and what the bones bear add up to nothing.
TEST(FibreForce, PullsOnBothEndsAlike) {
  Muscle muscle;
  const std::vector<Vec3> moved = moved_by(muscle, 1);
  Vec3 sum = Vec3::Zero();
  double sizes = 0;
  for (std::size_t row = 0; 2 * row + 1 < moved.size(); ++row) {
    sum += moved[2 * row + 1];
    sizes += moved[2 * row + 1].norm();
  }
  EXPECT_GT(sizes, 0);
  EXPECT_LT(sum.norm(), 1e-12 * sizes);
}

}  // namespace
}  // namespace musclebench
