#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include "core/base/parameters.hpp"
#include "core/contact/bone.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

Vec3 random_vector(std::mt19937_64& random) {
  const auto number = [&] { return 2 * static_cast<double>(random() >> 11) * 0x1p-53 - 1; };
  const double x = number();
  const double y = number();
  return {x, y, number()};
}

bool pierces(const Vec3& from, const Vec3& to, const std::array<Vec3, 3>& face) {
  constexpr double rounding_m3 = 1e-14;
  const auto side = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const double volume_m3 = (b - a).cross(c - a).dot(d - a);
    return std::abs(volume_m3) < rounding_m3 ? 0 : (volume_m3 > 0 ? 1 : -1);
  };
  const auto& [a, b, c] = face;
  if (side(a, b, c, from) * side(a, b, c, to) >= 0) return false;
  const int first = side(from, to, a, b);
  return first != 0 && first == side(from, to, b, c) && first == side(from, to, c, a);
}

/// Pairs of an edge and a triangle without a common vertex, of all bodies of a mesh, that go through each other.
int crossings_in(const std::vector<Vec3>& at, const std::vector<Triangle>& triangles) {
  int found = 0;
  for (const Triangle& one : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = one[k];
      const int to = one[(k + 1) % 3];
      for (const Triangle& other : triangles) {
        const auto has = [&](int node) { return node == other[0] || node == other[1] || node == other[2]; };
        if (has(from) || has(to)) continue;
        const auto corner = [&](std::size_t i) { return at[static_cast<std::size_t>(other[i])]; };
        if (pierces(at[static_cast<std::size_t>(from)], at[static_cast<std::size_t>(to)],
                    {corner(0), corner(1), corner(2)})) {
          ++found;
        }
      }
    }
  }
  return found;
}

void append(const TriangleMesh& part, const Vec3& by, TriangleMesh& all, std::vector<Body>& bodies) {
  const auto first = static_cast<int>(all.vertices.size());
  Body body{"part", first, 0, all.triangles.size(), 0};
  for (const Vec3& vertex : part.vertices) all.vertices.push_back(vertex + by);
  for (const Triangle& triangle : part.triangles) {
    all.triangles.push_back({triangle[0] + first, triangle[1] + first, triangle[2] + first});
  }
  body.last_node = static_cast<int>(all.vertices.size());
  body.last_triangle = all.triangles.size();
  bodies.push_back(body);
}

/// Two balls of muscle beside a ball of bone, of radius 1, moved at random.
class NoPassageTest : public testing::Test {
 protected:
  NoPassageTest() {
    const TriangleMesh ball = make_sphere(1, 1);
    append(ball, {-1.2, 0, 0}, m_mesh, m_bodies);
    append(ball, {1.2, 0, 0}, m_mesh, m_bodies);
    m_bones.push_back(Bone{"bone", {.mesh = ball, .clean = true, .changes = {}}});
    m_masses.assign(m_mesh.vertices.size(), 1);
    m_rest = {Mat3::Identity(), Vec3(0, 0, 2.2)};
  }

  [[nodiscard]] std::unique_ptr<ContactStage> stage(int threads = 1, bool with_itself = true) const {
    const EffectEntry* entry = find_effect("no_passage");
    return entry->make_stage({.bones = m_bones,
                              .nodes = m_mesh.vertices.size(),
                              .triangles = m_mesh.triangles,
                              .inverse_masses = m_masses,
                              .bound_nodes = m_bound,
                              .threads = threads,
                              .mesh = &m_mesh,
                              .bodies = m_bodies},
                             Parameters(entry->parameters, {{"gap_m", 1e-3}, {"itself", with_itself}}, "test"));
  }

  /// Muscles and the bone in one mesh.
  [[nodiscard]] int crossings(const std::vector<Vec3>& at, const RigidMotion& pose) const {
    std::vector<Vec3> all = at;
    std::vector<Triangle> triangles = m_mesh.triangles;
    const auto first = static_cast<int>(all.size());
    for (const Vec3& vertex : m_bones[0].surface.mesh.vertices) all.push_back(pose.apply(vertex));
    for (const Triangle& t : m_bones[0].surface.mesh.triangles) {
      triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    return crossings_in(all, triangles);
  }

  /// Moves all by random displacements of up to `size`, step by step, and the bone by as much; where all ended.
  std::vector<Vec3> shake(ContactStage& stage, double size, int steps, bool& was_crossed) {
    std::mt19937_64 random(7);
    std::vector<Vec3> start = m_mesh.vertices;
    std::vector<RigidMotion> poses{m_rest};
    for (int step = 0; step < steps; ++step) {
      std::vector<Vec3> proposed;
      const Vec3 towards = 0.3 * size * random_vector(random);
      for (std::size_t node = 0; node < start.size(); ++node) {
        const bool is_left = m_bodies[0].has_node(static_cast<int>(node));
        proposed.push_back(start[node] + (is_left ? towards : Vec3(-towards)) + size * random_vector(random));
      }
      std::vector<RigidMotion> next{RigidMotion::about_axis(Vec3::UnitX(), Vec3::Zero(), 0.3 * size) * poses[0]};
      next[0].translation_m = m_rest.translation_m + size * random_vector(random);
      was_crossed = was_crossed || crossings(proposed, next[0]) > 0;
      (void)stage.before_bones({start, proposed, {}, poses, next, {}});
      (void)stage.end_substep({start, proposed, {}, poses, next, {}});
      if (m_begins_apart) {
        EXPECT_EQ(crossings(proposed, next[0]), 0) << "step " << step << " of size " << size;
      }
      start = proposed;
      poses = next;
    }
    return start;
  }

  bool m_begins_apart = true;
  TriangleMesh m_mesh;
  std::vector<Body> m_bodies;
  std::vector<Bone> m_bones;
  std::vector<double> m_masses;
  std::vector<BoundNode> m_bound;
  RigidMotion m_rest;
};

TEST_F(NoPassageTest, NothingPassesWhateverIsProposed) {
  for (const double size : {0.1, 0.3, 3.0}) {
    bool was_crossed = false;
    const auto guard = stage();
    shake(*guard, size, 12, was_crossed);
    EXPECT_TRUE(was_crossed) << size;
    EXPECT_GT(guard->contact_count(), 0);
  }
}

TEST_F(NoPassageTest, ThreadsChangeNoBit) {
  bool was_crossed = false;
  EXPECT_EQ(shake(*stage(1), 0.3, 6, was_crossed), shake(*stage(3), 0.3, 6, was_crossed));
  m_begins_apart = false;
  m_rest.translation_m = Vec3(-1.13, 0.07, 1.2);  // through the left ball
  EXPECT_EQ(shake(*stage(1), 0.1, 12, was_crossed), shake(*stage(3), 0.1, 12, was_crossed));
}

TEST_F(NoPassageTest, ProcessorsChangeNoBit) {
  bool was_crossed = false;
  const std::vector<Vec3> wanted = shake(*stage(), 0.3, 6, was_crossed);
  const std::int64_t all = hwy::SupportedTargets();
  for (std::int64_t rest = all; rest != 0; rest &= rest - 1) {
    hwy::SetSupportedTargetsForTest(rest & -rest);
    EXPECT_EQ(shake(*stage(), 0.3, 6, was_crossed), wanted) << hwy::TargetName(rest & -rest);
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST_F(NoPassageTest, OnlyTheGuardAgainstItselfHoldsAFoldApart) {
  // One muscle, folded over: its upper half is pushed through the lower one.
  m_mesh = make_sphere(1, 2);
  m_bodies = {Body{"ball", 0, static_cast<int>(m_mesh.vertices.size()), 0, m_mesh.triangles.size()}};
  m_masses.assign(m_mesh.vertices.size(), 1);
  m_rest.translation_m = Vec3(0, 0, 1000);
  for (const bool with_itself : {true, false}) {
    std::vector<Vec3> proposed = m_mesh.vertices;
    for (Vec3& node : proposed) node += node.z() > 0.1 ? Vec3(0.13, 0.07, -1.5) : Vec3(0, 0, 0);
    const int proposed_crossings = crossings_in(proposed, m_mesh.triangles);
    std::vector<Vec3> start = m_mesh.vertices;
    const std::vector<RigidMotion> poses{m_rest};
    const auto guard = stage(1, with_itself);
    (void)guard->before_bones({start, proposed, {}, poses, poses, {}});
    (void)guard->end_substep({start, proposed, {}, poses, poses, {}});
    EXPECT_GT(proposed_crossings, 0);
    EXPECT_EQ(crossings_in(proposed, m_mesh.triangles), with_itself ? 0 : proposed_crossings);
  }
}

TEST_F(NoPassageTest, WhatMeetsNothingIsLeftAlone) {
  std::vector<Vec3> start = m_mesh.vertices;
  std::vector<Vec3> proposed = start;
  for (Vec3& node : proposed) node += Vec3(50, 20, -3);  // beneath the bone, and as one
  const std::vector<Vec3> wanted = proposed;
  const std::vector<RigidMotion> poses{m_rest};
  const auto guard = stage();
  (void)guard->before_bones({start, proposed, {}, poses, poses, {}});
  EXPECT_TRUE(guard->end_substep({start, proposed, {}, poses, poses, {}}).empty());
  EXPECT_EQ(proposed, wanted);
}

TEST_F(NoPassageTest, MusclesThatFlyThroughEachOtherStayOnTheirSides) {
  m_rest.translation_m = Vec3(0, 0, 1000);  // out of the way of what is thrown aside
  std::vector<Vec3> start = m_mesh.vertices;
  std::vector<Vec3> proposed = start;
  for (std::size_t node = 0; node < start.size(); ++node) {
    proposed[node].x() += m_bodies[0].has_node(static_cast<int>(node)) ? 100 : -100;
  }
  const std::vector<RigidMotion> poses{m_rest};
  const auto guard = stage();
  (void)guard->before_bones({start, proposed, {}, poses, poses, {}});
  (void)guard->end_substep({start, proposed, {}, poses, poses, {}});
  double left = 0;
  double right = 0;
  for (std::size_t node = 0; node < start.size(); ++node) {
    (m_bodies[0].has_node(static_cast<int>(node)) ? left : right) += proposed[node].x();
  }
  EXPECT_LT(left, right);
  EXPECT_NEAR(left + right, 0, 1e-9 * std::abs(left));  // rows and zones change no momentum
}

TEST_F(NoPassageTest, NodesThatRestOnTheBoneAreKeptOnIt) {
  // The lowest node of a muscle touches the highest of the bone, which says nothing of the side that it is on.
  m_rest.translation_m = Vec3(-1.2, 0, -2.0);
  std::vector<Vec3> start = m_mesh.vertices;
  const std::vector<RigidMotion> poses{m_rest};
  for (const double size : {1.0, 150.0}) {
    std::vector<Vec3> proposed = start;
    for (Vec3& node : proposed) node += size * Vec3(0.003, 0.002, -0.01);
    ASSERT_GT(crossings(proposed, m_rest), 0);
    const auto guard = stage();
    (void)guard->before_bones({start, proposed, {}, poses, poses, {}});
    (void)guard->end_substep({start, proposed, {}, poses, poses, {}});
    EXPECT_EQ(crossings(proposed, m_rest), 0) << size;
    EXPECT_EQ(guard->gave_up(), "") << size;
  }
}

TEST_F(NoPassageTest, WhatBeginsInsideMayLeaveAndThenStaysOut) {
  m_rest.translation_m = Vec3(-1.13, 0.07, -1.2);  // more than half of the left ball is in it, whole triangles of it
  std::vector<Vec3> start = m_mesh.vertices;
  const std::vector<RigidMotion> poses{m_rest};
  ASSERT_GT(crossings(start, m_rest), 0);
  const auto guard = stage();
  const auto move_left_ball = [&](const Vec3& by) {
    std::vector<Vec3> proposed = start;
    for (std::size_t node = 0; node < start.size(); ++node) {
      if (m_bodies[0].has_node(static_cast<int>(node))) proposed[node] += by;
    }
    const std::vector<Vec3> wanted = proposed;
    (void)guard->before_bones({start, proposed, {}, poses, poses, {}});
    (void)guard->end_substep({start, proposed, {}, poses, poses, {}});
    start = proposed;
    return proposed == wanted;
  };
  int steps = 0;
  // And no farther, so that the step that throws it back is the first in which it is out.
  for (; crossings(start, m_rest) > 0 && steps < 100; ++steps) EXPECT_TRUE(move_left_ball(Vec3(0.004, 0.008, 0.1)));
  ASSERT_EQ(crossings(start, m_rest), 0);
  EXPECT_GT(steps, 5);
  EXPECT_FALSE(move_left_ball(Vec3(0, 0, -1.5)));
  EXPECT_EQ(crossings(start, m_rest), 0);
}

/// Two triangles that intersect may have features that are all apart: an edge goes through the inside of a face.
TEST_F(NoPassageTest, LargeTrianglesMayLeaveWhatTheyGoThrough) {
  m_bones.assign(1, Bone{"block", {.mesh = make_box(Vec3(1, 1, 1), 1), .clean = true, .changes = {}}});
  m_mesh = make_box(Vec3(0.3, 0.3, 1), 1);
  m_bodies = {Body{"post", 0, static_cast<int>(m_mesh.vertices.size()), 0, m_mesh.triangles.size()}};
  m_masses.assign(m_mesh.vertices.size(), 1);
  for (const double side : {1.0, -1.0}) {
    m_rest.translation_m = Vec3(0.13, 0.07, -side);
    std::vector<Vec3> start = m_mesh.vertices;
    const std::vector<RigidMotion> poses{m_rest};
    const auto guard = stage();
    for (int step = 0; step < 60; ++step) {
      std::vector<Vec3> proposed = start;
      for (Vec3& node : proposed) node += Vec3(0.001, 0, 0.02 * side);
      const std::vector<Vec3> wanted = proposed;
      (void)guard->before_bones({start, proposed, {}, poses, poses, {}});
      (void)guard->end_substep({start, proposed, {}, poses, poses, {}});
      EXPECT_EQ(proposed, wanted) << side << ", " << step;
      start = proposed;
    }
  }
}

/// A ball whose lower half is bound to the bone, and its upper half pushed through that.
class HeldBallTest : public NoPassageTest {
 protected:
  HeldBallTest() {
    m_mesh = make_sphere(1, 2);
    m_bodies = {Body{"ball", 0, static_cast<int>(m_mesh.vertices.size()), 0, m_mesh.triangles.size()}};
    m_masses.assign(m_mesh.vertices.size(), 1);
    for (int node = 0; node < m_bodies[0].last_node; ++node) {
      if (m_mesh.vertices[static_cast<std::size_t>(node)].z() > -0.1) continue;
      m_bound.push_back({node, 0});
      m_masses[static_cast<std::size_t>(node)] = 0;
    }
    m_rest.translation_m = Vec3(0, 0, -30);
  }

  /// Moves the bone and what is above `from_m`; what the stage then says that it could not do.
  std::string push(const Vec3& bone_by, double from_m, const Vec3& by) {
    std::vector<Vec3> start = m_mesh.vertices;
    std::vector<Vec3> proposed = start;
    for (Vec3& node : proposed) node += node.z() > from_m ? by : Vec3(0, 0, 0);
    const std::vector<RigidMotion> poses{m_rest};
    std::vector<RigidMotion> next = poses;
    next[0].translation_m += bone_by;
    const auto guard = stage();
    (void)guard->before_bones({start, proposed, {}, poses, next, {}});
    (void)guard->end_substep({start, proposed, {}, poses, next, {}});
    m_end = proposed;
    return guard->gave_up();
  }

  std::vector<Vec3> m_end;
};

/// No effect need carry them: then they stay where they are, wherever their bone goes.
TEST_F(HeldBallTest, NodesThatStandStillAreNotTakenAlongByTheirBone) {
  EXPECT_EQ(push({0.2, 0.1, -1.2}, 0.1, {0.13, 0.07, -1.5}), "");
  EXPECT_EQ(crossings_in(m_end, m_mesh.triangles), 0);
}

TEST_F(HeldBallTest, ABoneThatComesThroughThemIsTold) {
  m_bound.assign(1, {m_bound.front().node, 1});
  m_bones.push_back(Bone{"other", m_bones[0].surface});
  m_rest.translation_m = Vec3(0, 0, 4);
  std::vector<Vec3> start = m_mesh.vertices;
  std::vector<Vec3> proposed = start;
  const std::vector<RigidMotion> poses{m_rest, {Mat3::Identity(), Vec3(0, 0, -40)}};
  const std::vector<RigidMotion> next{{Mat3::Identity(), Vec3(0, 0, -1)}, poses[1]};
  const auto guard = stage();
  (void)guard->before_bones({start, proposed, {}, poses, next, {}});
  (void)guard->end_substep({start, proposed, {}, poses, next, {}});
  EXPECT_EQ(guard->gave_up(), "ball is between bone and other, which come together");
}

/// Two balls that begin in each other: two muscles, or parts of one.
TEST_F(NoPassageTest, MusclesThatBeginInEachOtherMayPartAndThenStayApart) {
  m_mesh = {};
  const TriangleMesh ball = make_sphere(1, 1);
  m_bodies.clear();
  append(ball, {-0.4, 0, 0}, m_mesh, m_bodies);
  append(ball, {0.45, 0.05, 0.03}, m_mesh, m_bodies);
  m_rest.translation_m = Vec3(0, 0, 1000);
  const Body left = m_bodies[0];
  const std::vector<RigidMotion> poses{m_rest};
  for (const bool is_one : {false, true}) {
    if (is_one) m_bodies = {Body{"both", 0, m_bodies[1].last_node, 0, m_bodies[1].last_triangle}};
    std::vector<Vec3> start = m_mesh.vertices;
    const auto guard = stage();
    const auto move_left_ball = [&](const Vec3& by) {
      std::vector<Vec3> proposed = start;
      for (std::size_t node = 0; node < start.size(); ++node) {
        if (left.has_node(static_cast<int>(node))) proposed[node] += by;
      }
      const std::vector<Vec3> wanted = proposed;
      (void)guard->before_bones({start, proposed, {}, poses, poses, {}});
      (void)guard->end_substep({start, proposed, {}, poses, poses, {}});
      start = proposed;
      return proposed == wanted;
    };
    ASSERT_GT(crossings_in(start, m_mesh.triangles), 0);
    int steps = 0;
    for (; crossings_in(start, m_mesh.triangles) > 0 && steps < 100; ++steps) {
      EXPECT_TRUE(move_left_ball(Vec3(-0.1, 0.004, 0.008))) << is_one << ", " << steps;
    }
    EXPECT_GT(steps, 5) << is_one;
    EXPECT_FALSE(move_left_ball(Vec3(1.5, 0, 0))) << is_one;
    EXPECT_EQ(crossings_in(start, m_mesh.triangles), 0) << is_one;
  }
}

/// No triangle of it goes through the bone, so that only its being inside says that it has to get out.
TEST_F(NoPassageTest, WhatBeginsWhollyInsideIsFreeOnceTheBoneJumpsOff) {
  m_mesh = make_sphere(0.3, 1);
  m_bodies = {Body{"ball", 0, static_cast<int>(m_mesh.vertices.size()), 0, m_mesh.triangles.size()}};
  m_masses.assign(m_mesh.vertices.size(), 1);
  m_rest.translation_m = Vec3(0.1, 0, 0);
  std::vector<Vec3> start = m_mesh.vertices;
  std::vector<RigidMotion> poses{m_rest};
  const auto guard = stage();
  const auto move_bone_to = [&](const Vec3& place_m) {
    std::vector<RigidMotion> next = poses;
    next[0].translation_m = place_m;
    std::vector<Vec3> proposed = start;
    (void)guard->before_bones({start, proposed, {}, poses, next, {}});
    (void)guard->end_substep({start, proposed, {}, poses, next, {}});
    const bool has_moved = proposed != start;
    start = proposed;
    poses = next;
    return has_moved;
  };
  EXPECT_FALSE(move_bone_to({0.15, 0, 0}));
  EXPECT_FALSE(move_bone_to({5, 0, 0}));
  EXPECT_TRUE(move_bone_to({0.1, 0, 0})) << "what is free is pushed along";
  for (const Vec3& node : start) EXPECT_GT((node - poses[0].translation_m).norm(), 0.9);
}

/// Normals at the rim of a plate are those of its large faces, and say nothing of what its narrow side meets.
TEST_F(NoPassageTest, ANarrowSideIsHeldByAWall) {
  m_bones.assign(1, Bone{"wall", {.mesh = make_box(Vec3(1, 5, 5), 1), .clean = true, .changes = {}}});
  for (const double thickness : {0.4, 0.02}) {
    for (const double gap_share : {0.0, 0.1}) {
      m_mesh = make_box(Vec3(1, 1, thickness), 3);
      m_bodies = {Body{"plate", 0, static_cast<int>(m_mesh.vertices.size()), 0, m_mesh.triangles.size()}};
      m_masses.assign(m_mesh.vertices.size(), 1);
      m_rest.translation_m = Vec3(2 + 1e-3 * gap_share, 0.1, 0.05);
      std::vector<Vec3> start = m_mesh.vertices;
      const std::vector<RigidMotion> poses{m_rest};
      const auto guard = stage();
      double step_m = 0.75e-3 * gap_share;  // at first closer and closer
      for (int step = 0; step < 20; ++step) {
        std::vector<Vec3> proposed = start;
        for (Vec3& node : proposed) node.x() += step < 8 ? step_m : 0.01;
        step_m *= 0.25;
        (void)guard->before_bones({start, proposed, {}, poses, poses, {}});
        (void)guard->end_substep({start, proposed, {}, poses, poses, {}});
        start = proposed;
      }
      double farthest_m = 0;
      for (const Vec3& node : start) farthest_m = std::max(farthest_m, node.x() - m_rest.translation_m.x() + 1);
      EXPECT_LT(farthest_m, 1e-9) << thickness << " thick, from " << gap_share << " of the gap";
    }
  }
}

}  // namespace
}  // namespace musclebench
