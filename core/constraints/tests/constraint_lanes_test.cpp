#include "core/constraints/constraint_lanes.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include "core/effects/reference/scalar_effect.hpp"
#include "core/effects/surface_edges.hpp"
#include "core/effects/tests/effects_fixture.hpp"
#include "core/mesh/shapes.hpp"

// Constraints in SIMD lanes and threads against the same constraints one after the other.
namespace musclebench {
namespace {

/// A disc about one vertex, whose spokes cannot be projected side by side.
TriangleMesh fan(int spokes) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.01, 0.02, 0.03);
  for (int i = 0; i < spokes; ++i) {
    const double angle = 2 * M_PI * i / spokes;
    mesh.vertices.emplace_back(0.1 * std::cos(angle), 0.1 * std::sin(angle), 0.01 * std::cos(3 * angle));
    mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % spokes});
  }
  return mesh;
}

/// A torn sphere: boundary edges, and components of one triangle.
TriangleMesh torn_sphere() {
  TriangleMesh mesh = make_sphere(0.1, 2);
  std::erase_if(mesh.triangles, [](const Triangle& t) { return t[0] % 5 == 0; });
  const int count = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{0.2, 0, 0}, {0.21, 0, 0}, {0.2, 0.01, 0}});
  mesh.triangles.push_back({count, count + 1, count + 2});
  return mesh;
}

std::vector<std::array<int, 2>> edges_of(const TriangleMesh& mesh) {
  std::vector<std::array<int, 2>> edges;
  for (const SurfaceEdge& edge : surface_edges(mesh)) {
    edges.push_back({edge.start, edge.end});
  }
  return edges;
}

NodeOrder order_of(const TriangleMesh& mesh) {
  return {mesh.vertices, std::vector<Body>{{"muscle", 0, static_cast<int>(mesh.vertices.size())}}};
}

int row_at(const ConstraintOrder<2>& order, std::size_t end, std::size_t slot) {
  return order.row_offsets(end)[slot] / row_offset(1);
}

using SlotRange = std::pair<std::size_t, std::size_t>;

/// Of each thread of a team: the slots that it takes, in order.
template <std::size_t N>
std::vector<std::vector<SlotRange>> ranges_of_team(const ConstraintOrder<N>& order, int threads) {
  Barrier barrier(threads);
  std::vector<std::vector<SlotRange>> found(static_cast<std::size_t>(threads));
  std::vector<std::thread> team;
  for (int thread = 0; thread < threads; ++thread) {
    team.emplace_back([&, thread] {
      order.for_each(Team(thread, threads, barrier), [&](std::size_t first, std::size_t last) {
        found[static_cast<std::size_t>(thread)].emplace_back(first, last);
      });
    });
  }
  for (std::thread& thread : team) thread.join();
  return found;
}

TEST(ConstraintOrder, KeepsTheGivenOrderAtEachNodeAndNoCallHasANodeTwice) {
  for (const TriangleMesh& mesh : {fan(100), torn_sphere(), make_sphere(1, 3)}) {
    const std::vector<std::array<int, 2>> edges = edges_of(mesh);
    const NodeOrder nodes_of_rows = order_of(mesh);
    const ConstraintOrder<2> order(edges, nodes_of_rows);
    ASSERT_EQ(order.size() % constraint_lanes, 0U);
    std::vector<int> last_of_node(mesh.vertices.size(), -1);
    std::size_t constraints = 0;
    for (std::size_t slot = 0; slot < order.size(); ++slot) {
      const int constraint = order.slots()[slot];
      const std::array<int, 2> rows{row_at(order, 0, slot), row_at(order, 1, slot)};
      if (constraint < 0) {
        const int padding = static_cast<int>(mesh.vertices.size());
        EXPECT_EQ(rows, (std::array<int, 2>{padding, padding}));
      } else {
        ++constraints;
        const std::array<int, 2> nodes = edges[static_cast<std::size_t>(constraint)];
        EXPECT_EQ(rows, (std::array<int, 2>{nodes_of_rows.row_of(nodes[0]), nodes_of_rows.row_of(nodes[1])}));
        for (const int node : nodes) {
          EXPECT_LT(last_of_node[node], constraint) << "node " << node;
          last_of_node[node] = constraint;
        }
      }
    }
    EXPECT_EQ(constraints, edges.size());
    std::size_t next = 0;
    const std::vector<SlotRange> calls = ranges_of_team(order, 1).front();
    for (const auto& [first, last] : calls) {
      EXPECT_EQ(first, next);
      EXPECT_EQ(first % constraint_lanes, 0U);
      std::multiset<int> nodes;
      for (std::size_t slot = first; slot < last; ++slot) {
        if (order.slots()[slot] < 0) continue;
        nodes.insert({row_at(order, 0, slot), row_at(order, 1, slot)});
      }
      EXPECT_EQ(nodes.size(), std::set<int>(nodes.begin(), nodes.end()).size()) << "slots " << first << " to " << last;
      next = last;
    }
    EXPECT_EQ(next, order.size());
  }
}

/// What threads do at the same time, between two waits, shares no node.
TEST(ConstraintOrder, WhatThreadsShareHasNoNodeInCommon) {
  const TriangleMesh mesh = make_sphere(1, 4);
  const std::vector<std::array<int, 2>> edges = edges_of(mesh);
  const NodeOrder nodes_of_rows = order_of(mesh);
  const ConstraintOrder<2> order(edges, nodes_of_rows);
  const std::vector<SlotRange> stages = ranges_of_team(order, 1).front();
  for (const std::size_t threads : {2U, 3U, 8U}) {
    const std::vector<std::vector<SlotRange>> team = ranges_of_team(order, static_cast<int>(threads));
    std::vector<int> visits(order.size(), 0);
    std::size_t shared = 0;
    for (std::size_t stage = 0; stage < stages.size(); ++stage) {
      // Others than the first have a range, which may be empty, in each stage that is shared.
      std::vector<SlotRange> ranges = {team[0].at(stage)};
      if (ranges[0] != stages[stage]) {
        for (std::size_t thread = 1; thread < threads; ++thread) ranges.push_back(team[thread].at(shared));
        ++shared;
      }
      std::set<int> nodes_of_others;
      for (const auto& [first, last] : ranges) {
        std::set<int> nodes;
        for (std::size_t slot = first; slot < last; ++slot) {
          ++visits[slot];
          if (order.slots()[slot] >= 0) nodes.insert({row_at(order, 0, slot), row_at(order, 1, slot)});
        }
        for (const int node : nodes) {
          EXPECT_TRUE(nodes_of_others.insert(node).second) << "node " << node;
        }
      }
    }
    EXPECT_EQ(shared, team[1].size());
    EXPECT_GT(shared, 3U);
    EXPECT_EQ(visits, std::vector<int>(order.size(), 1));
  }
}

/// A thread that is slow in one run holds up the others: the next has the same nodes.
TEST(ConstraintOrder, NoThreadBeginsARunBeforeAllHaveEndedTheLast) {
  const TriangleMesh mesh = make_sphere(1, 4);
  const ConstraintOrder<2> order(edges_of(mesh), order_of(mesh));
  ASSERT_NE(ranges_of_team(order, 2)[0][0], ranges_of_team(order, 1)[0][0]) << "the first run is not shared";
  Barrier barrier(2);
  std::atomic<int> calls_of_quick = 0;
  std::atomic<bool> slow_has_ended = false;
  std::atomic<bool> was_overtaken = false;
  std::thread quick([&] {
    order.for_each(Team(1, 2, barrier), [&](std::size_t, std::size_t) {
      if (++calls_of_quick == 2 && !slow_has_ended) was_overtaken = true;
    });
  });
  order.for_each(Team(0, 2, barrier), [&](std::size_t, std::size_t) {
    // Long enough for the other to go on if nothing keeps it; where it waits, as it has to, this only takes time.
    for (int i = 0; i < 200 && calls_of_quick < 2 && !slow_has_ended; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    slow_has_ended = true;
  });
  quick.join();
  EXPECT_FALSE(was_overtaken);
}

/// A muscle out of shape, whose nodes differ in mass.
struct Deformed : Fixture {
  Nodes start;

  explicit Deformed(TriangleMesh of) : Fixture(std::move(of), {{{-0.2, 0.01, 0.02}, {0.2, 0.05, 0.03}}}) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    start = particles();
    for (std::size_t i = 0; i < start.size(); ++i) {
      start.predicted[i] += 0.002 * Vec3(unit(random), unit(random), unit(random));
      start.inverse_masses[i] = i % 11 == 3 ? 0 : 1.5 + unit(random);
    }
  }

  /// An edge without length and triangles without height.
  void collapse_an_edge() { start.predicted[mesh.triangles[0][1]] = start.predicted[mesh.triangles[0][0]]; }
};

struct EffectCase {
  std::string effect;
  std::map<std::string, ParameterValue> parameters;
};

std::vector<EffectCase> effect_cases() {
  return {{"edge_length", {}},
          {"edge_length", {{"compliance_m_per_n", 2e-6}, {"visits_per_edge", std::int64_t{2}}}},
          {"edge_length", {{"anisotropy_exponent", 2.0}, {"stiffness", 0.7}}},
          {"bending", {}},
          {"bending", {{"compliance_rad_per_n_m", 1e-4}, {"stiffness", 1.0}}},
          {"bending", {{"public_code_ratio_gate", true}}},
          {"bending", {{"skip_flatter_than_rad", 0.1}}},
          {"volume", {}},
          {"volume", {{"pressure", 1.3}, {"projection_scale", 1.0 / 6}}},
          {"local_volume", {}},
          {"local_volume", {{"regions", std::int64_t{30}}, {"pressure", 1.1}, {"projection_scale", 0.5}}}};
}

/// Two substeps of three iterations each.
std::vector<Vec3> by_lanes(Deformed& muscle, const EffectCase& of, int threads) {
  const auto effect = muscle.make(of.effect, of.parameters);
  Nodes p = muscle.start;
  NodeRows rows(muscle.order, p.predicted, p.inverse_masses);
  std::vector<NodeRow> velocities(rows.size());
  const SubstepInput input{1e-3, muscle.poses};
  Barrier barrier(threads);
  std::vector<std::thread> team;
  for (int thread = 0; thread < threads; ++thread) {
    team.emplace_back([&, thread] {
      const Team member(thread, threads, barrier);
      for (int substep = 0; substep < 2; ++substep) {
        effect->apply_force(rows, velocities, input, member);
        member.wait();
        for (int iteration = 0; iteration < 3; ++iteration) {
          effect->project(rows, input, member);
          member.wait();
        }
      }
    });
  }
  for (std::thread& thread : team) thread.join();
  std::vector<Vec3> found(rows.size());
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const int node = muscle.order.node_in(row);
    EXPECT_EQ(rows[row].inverse_mass, p.inverse_masses[node]);
    found[node] = rows[row].position();
  }
  return found;
}

std::vector<Vec3> one_by_one(Deformed& muscle, const EffectCase& of) {
  const EffectEntry* entry = find_effect(of.effect);
  const auto effect = make_scalar_effect(
      of.effect, {muscle.mesh, muscle.bodies, muscle.order, muscle.fibres, muscle.bound, muscle.poses},
      Parameters(entry->parameters, of.parameters, "test"));
  Nodes p = muscle.start;
  for (int substep = 0; substep < 2; ++substep) {
    effect->begin_substep();
    for (int iteration = 0; iteration < 3; ++iteration) {
      effect->project(p.predicted, p.inverse_masses, {1e-3, muscle.poses});
    }
  }
  return p.predicted;
}

class ConstraintLanes : public testing::TestWithParam<EffectCase> {
 protected:
  static void expect_the_same_everywhere(Deformed& muscle, const std::vector<Vec3>& found) {
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      for (const int threads : {1, 2, 3, 8}) {
        ASSERT_EQ(by_lanes(muscle, GetParam(), threads), found) << hwy::TargetName(target) << ", " << threads;
      }
    }
    hwy::SetSupportedTargetsForTest(0);
  }

  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_P(ConstraintLanes, AreTheScalarConstraintsOnEverySimdTargetAndForAnyTeam) {
  double moved_m = 0;
  // The finest has runs so long that the threads of a team share them.
  for (const TriangleMesh& mesh : {make_sphere(0.1, 2), make_sphere(0.1, 3), torn_sphere(), fan(100)}) {
    Deformed muscle(mesh);
    const std::vector<Vec3> expected = one_by_one(muscle, GetParam());
    const std::vector<Vec3> found = by_lanes(muscle, GetParam(), 1);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_LE((found[i] - expected[i]).norm(), 1e-12) << "node " << i << " of " << expected.size();
      moved_m = std::max(moved_m, (found[i] - muscle.start.predicted[i]).norm());
      EXPECT_TRUE(muscle.start.inverse_masses[i] > 0 || found[i] == muscle.start.predicted[i]) << "node " << i;
    }
    expect_the_same_everywhere(muscle, found);
  }
  EXPECT_GT(moved_m, 1e-5);
}

TEST_P(ConstraintLanes, StayFiniteWhereAnEdgeHasNoLength) {
  Deformed muscle(make_sphere(0.1, 2));
  muscle.collapse_an_edge();
  const std::vector<Vec3> found = by_lanes(muscle, GetParam(), 1);
  for (const Vec3& x : found) {
    ASSERT_LT(x.norm(), 1);
  }
  expect_the_same_everywhere(muscle, found);
}

INSTANTIATE_TEST_SUITE_P(All, ConstraintLanes, testing::ValuesIn(effect_cases()),
                         [](const auto& named) { return named.param.effect + "_" + std::to_string(named.index); });

}  // namespace
}  // namespace musclebench
