#include "core/pbd/simulation.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// A half space z < height of bone 0 in its rest frame, answered exactly.
class HalfSpace final : public CollisionBackend {
 public:
  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }
  [[nodiscard]] double step_m(int /*bone*/) const override { return 0.125; }

 private:
  void do_build() override {}
  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    for (std::size_t bone = 0; bone < bones().size(); ++bone) {
      for (const int node : nodes) {
        const Vec3 x = poses()[bone].apply_inverse(positions[node]);
        if (x.z() < 0) {
          contacts.push_back({node, static_cast<int>(bone), -x.z(), poses()[bone].apply_to_direction(Vec3::UnitZ())});
        }
      }
    }
  }
};

const NodeOrder one_node{std::vector<Vec3>(1, Vec3::Zero()), std::vector<Body>{{"a", 0, 1}}};

Particles particles(const std::vector<Vec3>& positions) {
  Particles p;
  p.positions = positions;
  p.velocities.assign(positions.size(), Vec3(1, 0, 0));
  p.inverse_masses.assign(positions.size(), 1);
  return p;
}

TEST(Simulation, AFreeNodeFliesOn) {
  HalfSpace backend;
  backend.build({}, {}, 1);
  LoopParameters loop;
  loop.substeps = 5;
  loop.time_step_s = 0.01;
  Simulation simulation(loop, particles({Vec3(0, 0, 1)}), one_node, {}, backend, ResponseKind::project,
                        [](double, std::vector<RigidMotion>& poses) { poses.clear(); });
  simulation.step_frame(1);
  EXPECT_NEAR(simulation.velocities()[0].x(), 1, 1e-12);
  EXPECT_NEAR(simulation.positions()[0].x(), 0.05, 1e-12);
}

/// Without forces a velocity is the same whatever the step: 2 steps of 0.01 s, then 2 of 0.1 s.
TEST(Simulation, TheTimeStepOfTheFrameIsTheOneThatCounts) {
  HalfSpace backend;
  backend.build({}, {}, 1);
  LoopParameters loop;
  loop.substeps = 2;
  loop.time_step_s = 0.01;
  loop.time_step_changes = {{2, 0.1}};
  Simulation simulation(loop, particles({Vec3(0, 0, 1)}), one_node, {}, backend, ResponseKind::project,
                        [](double, std::vector<RigidMotion>& poses) { poses.clear(); });
  simulation.step_frame(1);
  simulation.step_frame(2);
  EXPECT_NEAR(simulation.velocities()[0].x(), 1, 1e-12);
  EXPECT_NEAR(simulation.positions()[0].x(), 0.22, 1e-12);
}

TEST(Simulation, PosesJumpOnceAFrameOrMoveInEverySubstep) {
  for (const bool interpolate : {false, true}) {
    HalfSpace backend;
    backend.build({}, {}, 1);
    LoopParameters loop;
    loop.substeps = 4;
    loop.interpolate_poses = interpolate;
    std::vector<double> asked;
    Simulation simulation(loop, particles({Vec3(0, 0, 1)}), one_node, {}, backend, ResponseKind::project,
                          [&](double position, std::vector<RigidMotion>& poses) {
                            asked.push_back(position);
                            poses.clear();
                          });
    asked.clear();
    simulation.step_frame(3);
    EXPECT_EQ(asked, interpolate ? (std::vector<double>{2.25, 2.5, 2.75, 3}) : (std::vector<double>{3, 3, 3, 3}));
  }
}

/// It would fly on by 1 m a frame; the velocity that it begins with is its own afterwards.
TEST(Simulation, WhatBeginsInABoneIsLaidOutOfItAndNotThrown) {
  for (const int settle_substeps : {0, 3}) {
    HalfSpace backend;
    const std::vector<Bone> bones(1);
    backend.build(bones, {}, 1);
    LoopParameters loop;
    loop.time_step_s = 1;
    loop.settle_substeps = settle_substeps;
    Simulation simulation(loop, particles({Vec3(0, 0, -1)}), one_node, {}, backend, ResponseKind::project,
                          [](double, std::vector<RigidMotion>& poses) { poses.assign(1, RigidMotion()); });
    simulation.settle();
    EXPECT_EQ(simulation.positions()[0], Vec3(0, 0, settle_substeps > 0 ? 0 : -1));
    EXPECT_EQ(simulation.velocities()[0], Vec3(1, 0, 0));
    simulation.step_frame(1);
    simulation.step_frame(2);
    EXPECT_EQ(simulation.positions()[0].z(), settle_substeps > 0 ? 0 : 1);
    EXPECT_EQ(simulation.positions()[0].x(), 2);
  }
}

TEST(Simulation, TheLastDetectionIsWhatTheBackendSaw) {
  HalfSpace backend;
  const std::vector<Bone> bones(1);
  backend.build(bones, {}, 1);
  LoopParameters loop;
  loop.time_step_s = 1;
  Particles falling = particles({Vec3(0, 0, 1)});
  falling.velocities[0] = Vec3(0, 0, -3);
  Simulation simulation(loop, falling, one_node, {}, backend, ResponseKind::project,
                        [](double, std::vector<RigidMotion>& poses) { poses.assign(1, RigidMotion{}); });
  LastDetection last;
  simulation.step_frame(1, &last);
  EXPECT_EQ(last.substep_start[0], Vec3(0, 0, 1));
  EXPECT_EQ(last.positions[0], Vec3(0, 0, -2));
  ASSERT_EQ(last.contacts.size(), 1U);
  EXPECT_EQ(last.contacts[0].depth_m, 2);
  EXPECT_EQ(simulation.positions()[0], Vec3(0, 0, 0));
}

/// Writes down what every collision step was told.
class Listener final : public CollisionObserver {
 public:
  std::vector<double> previous_z, z;  ///< of bone 0
  std::vector<bool> last_of_frame;

  void before_detection(const CollisionStep& step) override {
    previous_z.push_back(step.previous_bone_poses[0].translation_m.z());
    z.push_back(step.bone_poses[0].translation_m.z());
    last_of_frame.push_back(step.last_of_frame);
  }
  void after_detection(const CollisionStep& /*step*/, std::span<const Contact> /*contacts*/) override {}
};

/// Bone 0 rises by 1 m a frame.
PoseFunction rising() {
  return [](double position, std::vector<RigidMotion>& poses) {
    poses.assign(1, RigidMotion{Mat3::Identity(), Vec3(0, 0, position)});
  };
}

TEST(Simulation, EveryIterationCollidesAndOnlyTheLastEndsTheFrame) {
  HalfSpace backend;
  const std::vector<Bone> bones(1);
  backend.build(bones, {}, 1);
  LoopParameters loop;
  loop.substeps = 2;
  loop.iterations = 3;
  loop.interpolate_poses = true;
  Simulation simulation(loop, particles({Vec3(0, 0, 9)}), one_node, {}, backend, ResponseKind::project, rising());
  Listener listener;
  simulation.step_frame(1, &listener);
  EXPECT_EQ(listener.previous_z, (std::vector<double>{0, 0, 0, 0.5, 0.5, 0.5}));
  EXPECT_EQ(listener.z, (std::vector<double>{0.5, 0.5, 0.5, 1, 1, 1}));
  EXPECT_EQ(listener.last_of_frame, (std::vector<bool>{false, false, false, false, false, true}));
}

TEST(Simulation, TheResponseKnowsThePosesOfTheSubstepBefore) {
  HalfSpace backend;
  const std::vector<Bone> bones(1);
  backend.build(bones, {}, 1);
  LoopParameters loop;
  loop.substeps = 2;
  loop.interpolate_poses = true;
  Particles stuck = particles({Vec3(0, 0, -0.5)});
  stuck.velocities[0].setZero();
  Simulation simulation(loop, stuck, one_node, {}, backend, ResponseKind::backtrack, rising());
  simulation.step_frame(1);
  EXPECT_EQ(simulation.positions()[0], Vec3(0, 0, 0.5));  // it follows the bone that it is in
  simulation.step_frame(2);
  EXPECT_EQ(simulation.positions()[0], Vec3(0, 0, 1.5));
}

}  // namespace
}  // namespace musclebench
