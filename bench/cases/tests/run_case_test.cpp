#include "bench/cases/run_case.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/coupled_judge.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/split_mesh.hpp"
#include "core/referee/tests/test_bones.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {
namespace {

/// A free muscle, a ball 0.2 m from the axis, and a bone, a larger ball about the axis that turns by `turn_rad` from
/// `start_rad` away from the muscle.
Scene ball_against_ball(double start_rad, double turn_rad, int frames) {
  Scene scene;
  scene.name = "ball against ball";
  const RigidMotion start = RigidMotion::about_axis(Vec3::UnitZ(), Vec3::Zero(), start_rad);
  scene.bones.push_back(bone_of(moved(moved(make_sphere(0.05, 3), Vec3(0.2, 0, 0)), start)));
  scene.bone_meshes.push_back({"bone", "", scene.bones[0].surface.mesh});
  BoneRotation motion;
  motion.axis = Vec3::UnitZ();
  motion.times = {0, 1};
  motion.angles_rad = {0, turn_rad};
  motion.there_and_back = false;
  scene.motions.push_back({{motion}});
  scene.add_muscle("muscle", moved(make_sphere(0.02, 3), Vec3(0.2, 0, 0)));
  scene.loop.frames = frames;
  return scene;
}

RunResult run_without_collision(const Scene& scene, bool judge = true) {
  const BackendEntry& backend = find_backend("null");
  RunCase run{{scene, backend, Parameters(backend.parameters, {}, backend.name)}};
  run.judge = judge;
  return run_case(run, [](int) {});
}

TEST(RunCaseStatus, IsOkWhereNothingHappens) {
  const RunResult result = run_without_collision(ball_against_ball(1, 0, 3));
  EXPECT_EQ(result.status, "ok") << result.status_detail;
  EXPECT_EQ(result.outcome.max_edge_stretch, 1);
  EXPECT_EQ(result.outcome.nodes_inside_at_end, 0);
  EXPECT_EQ(result.outcome.max_volume_error, 0);
  EXPECT_EQ(result.records.size(), 3U);
}

TEST(RunCaseStatus, IsSuspectWhereABodyIsInAnotherUnit) {
  Scene scene = ball_against_ball(1, 0, 3);
  scene.warnings = {{"pieces", "the muscle is in 2 separate pieces"}};
  EXPECT_EQ(run_without_collision(scene).status, "ok");
  scene.warnings.push_back({"unit", "the muscle is 40 m large"});
  const RunResult result = run_without_collision(scene);
  EXPECT_EQ(result.status, "suspect");
  EXPECT_EQ(result.status_detail, "the muscle is 40 m large");
}

TEST(StartNoise, MovesFreeNodesByNoMoreAndAlwaysTheSame) {
  Scene scene = ball_against_ball(1, 0, 1);
  const RunResult still = run_without_collision(scene, false);
  scene.loop.start_noise_m = 1e-6;
  const BackendEntry& backend = find_backend("null");
  RunCase run{{scene, backend, Parameters(backend.parameters, {}, backend.name)}};
  run.judge = false;
  run.snapshots = {0, 1};
  const RunResult moved = run_case(run, [](int) {});
  EXPECT_NE(moved.state_hash, still.state_hash);
  EXPECT_EQ(moved.state_hash, run_without_collision(scene, false).state_hash);
  double largest_m = 0;
  for (std::size_t node = 0; node < scene.muscle_mesh.vertices.size(); ++node) {
    const Vec3 off_m = moved.snapshots[0].positions[node] - scene.muscle_mesh.vertices[node];
    EXPECT_GT(off_m.norm(), 0);
    largest_m = std::max(largest_m, off_m.cwiseAbs().maxCoeff());
  }
  EXPECT_LE(largest_m, 1e-6);
  EXPECT_GT(largest_m, 0.9e-6);
}

TEST(RunCaseStatus, IsSuspectWhereTheBoneSwallowsTheMuscle) {
  const RunResult result = run_without_collision(ball_against_ball(1, -1, 4));
  EXPECT_EQ(result.status, "suspect");
  EXPECT_NE(result.status_detail.find("mm deep"), std::string::npos) << result.status_detail;
  EXPECT_EQ(result.outcome.nodes_inside_at_end, static_cast<int>(result.rest.free_nodes));
}

TEST(RunCaseStatus, IsSuspectWhereTheBonePassesThroughTheMuscle) {
  const RunResult result = run_without_collision(ball_against_ball(1, -2, 3));
  EXPECT_EQ(result.status, "suspect");
  EXPECT_NE(result.status_detail.find("went through a bone"), std::string::npos) << result.status_detail;
}

TEST(RunCaseStatus, IsSuspectWhereTheMuscleStartsInTheBone) {
  const RunResult result = run_without_collision(ball_against_ball(0.22, 0.5, 2));
  EXPECT_EQ(result.status, "suspect");
  EXPECT_NE(result.status_detail.find("before the first frame"), std::string::npos) << result.status_detail;
  EXPECT_GT(*result.outcome.nodes_inside_at_rest, 0);
}

TEST(RunCaseStatus, NothingIsClaimedWhereNobodyJudged) {
  const RunResult result = run_without_collision(ball_against_ball(1, -1, 4), false);
  EXPECT_EQ(result.status, "ok");
  EXPECT_FALSE(result.outcome.max_depth_m || result.outcome.max_edge_stretch || result.outcome.nodes_inside_at_end);
}

TEST(JudgingBudget, GrowsWithTheFrame) {
  Scene scene = ball_against_ball(1, 0, 1);
  const long of_a_small_frame = judging_budget(scene);
  scene.loop.substeps = 2;
  EXPECT_EQ(judging_budget(scene), of_a_small_frame);
  scene.loop.substeps = 100;
  const long budget = judging_budget(scene);
  EXPECT_GT(budget, of_a_small_frame);
  scene.loop.substeps = 300;
  scene.loop.iterations = 2;
  EXPECT_EQ(judging_budget(scene), 6 * budget);
  scene.effects.assign(2, SceneEffect{"bending", Parameters({}, {}, "test")});
  EXPECT_GT(judging_budget(scene), 12 * budget);
}

/// A muscle without effects in the groove of a bone. Nothing moves. So many nodes that a frame of one substep can't pay
/// for a look at all of it.
Scene muscle_in_a_groove(const Vec3& shift, int substeps) {
  Scene scene;
  scene.name = "groove";
  scene.bones.push_back(bone_of(grooved_block()));
  scene.bone_meshes.push_back({"bone", "", scene.bones[0].surface.mesh});
  scene.motions.emplace_back();
  scene.add_muscle("muscle", moved(split_flat(groove_filling(), 2), shift));
  scene.loop.frames = 3;
  scene.loop.substeps = substeps;
  return scene;
}

struct JudgedFrame {
  StepRecord record;
  long budget, work, node_work, crossing_work;
};

std::vector<JudgedFrame> judge_frames(const Scene& scene, int threads) {
  const BackendEntry& entry = find_backend("null");
  const Case resolved{scene, entry, Parameters(entry.parameters, {}, entry.name)};
  const BuiltBackend built = build_backend(resolved);
  const PreparedSimulation prepared = prepare_simulation(scene, *built.backend, resolved.responses, 1);
  CoupledJudge judge(scene, prepared.bound_nodes, *prepared.simulation, threads);
  std::vector<JudgedFrame> frames;
  for (int frame = 1; frame <= scene.loop.frames; ++frame) {
    LastDetection detection;
    prepared.simulation->step_frame(frame, &detection);
    StepRecord record;
    judge.judge(*prepared.simulation, detection, record);
    frames.push_back({record, judge.budget(), judge.last_work(), judge.last_node_work(), judge.last_crossing_work()});
  }
  return frames;
}

TEST(JudgingBudget, IsDividedByTheThreadsOfTheFrame) {
  Scene scene = ball_against_ball(1, 0, 1);
  scene.loop.substeps = 100;
  EXPECT_EQ(judging_budget(scene, 4), judging_budget(scene) / 4);
}

TEST(JudgingBudget, IsKeptInAGroove) {
  constexpr long last_look = 5000;  // a cluster of vertices and a part of a face
  for (const Vec3& shift : {Vec3(0, 0, 0), Vec3(0.01, 0, -0.02)}) {
    for (const int substeps : {1, 8, 300}) {
      for (const int threads : {1, 4}) {
        const Scene scene = muscle_in_a_groove(shift, substeps);
        for (const JudgedFrame& frame : judge_frames(scene, threads)) {
          EXPECT_EQ(frame.budget, judging_budget(scene, threads));
          EXPECT_GT(frame.node_work, 0);
          EXPECT_LE(frame.work, std::max(frame.budget, frame.node_work + frame.budget / 4) + last_look);
          EXPECT_TRUE(frame.record.judged);
          EXPECT_GE(frame.record.surface_depth_bound_m, frame.record.surface_depth_m);
          if (substeps == 300 && threads == 1) {
            EXPECT_TRUE(frame.record.judgement_complete);
          }
          if (substeps == 1 && !shift.isZero(0)) {
            EXPECT_FALSE(frame.record.judgement_complete);
          }
        }
      }
    }
  }
}

TEST(JudgingBudget, TestsForCrossingsAsOftenAsItAllows) {
  for (const int substeps : {1, 30, 500}) {
    Scene scene = muscle_in_a_groove(Vec3(0.01, 0, -0.02), substeps);
    scene.loop.frames = 24;
    long allowed = 0, taken = 0, most = 0;
    int tested = 0;
    for (const JudgedFrame& frame : judge_frames(scene, 1)) {
      EXPECT_EQ(frame.crossing_work > 0, frame.record.bone_crossings.has_value());
      EXPECT_EQ(frame.crossing_work > 0, !frame.record.crossings.empty());
      if (frame.record.bone_crossings) {
        EXPECT_GT(*frame.record.bone_crossings, 20);
      }
      allowed += std::max(frame.budget - frame.work, frame.budget / 8);
      taken += frame.crossing_work;
      most = std::max(most, frame.crossing_work);
      tested += frame.crossing_work > 0 ? 1 : 0;
      EXPECT_LE(taken, allowed + most);
    }
    EXPECT_EQ(tested == 24, substeps == 500) << tested;
    EXPECT_GE(tested, substeps == 1 ? 0 : 2);
  }
}

TEST(RunCase, TestsKeptFramesAndTheLastForCrossings) {
  const Scene scene = [] {
    Scene still = muscle_in_a_groove(Vec3(0.01, 0, -0.02), 1);
    still.loop.frames = 12;
    return still;
  }();
  const BackendEntry& backend = find_backend("null");
  RunCase run{{scene, backend, Parameters(backend.parameters, {}, backend.name)}};
  run.snapshots = {0, 2, 5};
  const RunResult result = run_case(run, [](int) {});
  int tested = 0;
  for (const StepRecord& record : result.records) {
    tested += record.self_intersecting_triangles ? 1 : 0;
    if (record.frame == 2 || record.frame == 5 || record.frame == 12) {
      EXPECT_GT(record.bone_crossings, 20) << record.frame;
    }
  }
  EXPECT_LT(tested, 12);
  EXPECT_EQ(result.outcome.crossing_frames, tested);
  ASSERT_EQ(result.outcome.crossings.size(), 2U);
  EXPECT_EQ(result.outcome.crossings[0].triangles, result.outcome.bone_crossings);
  EXPECT_EQ(result.outcome.bone_crossings_at_rest, result.outcome.bone_crossings) << "nothing moves";
  EXPECT_EQ(result.outcome.self_intersecting_triangles_at_rest, 0);
}

TEST(JudgingBudget, LeavesRowsReproducible) {
  const Scene scene = muscle_in_a_groove(Vec3(0.01, 0, -0.02), 8);
  const std::vector<JudgedFrame> once = judge_frames(scene, 1);
  const std::vector<JudgedFrame> again = judge_frames(scene, 1);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].work, again[i].work);
    EXPECT_EQ(once[i].record.surface_depth_bound_m, again[i].record.surface_depth_bound_m);
    EXPECT_EQ(once[i].record.bone_vertex_depth_bound_m, again[i].record.bone_vertex_depth_bound_m);
  }
}

TEST(BuildBackend, WhatBonesShareStaysUntilTheSimulationIsPrepared) {
  Scene scene = ball_against_ball(0.4, 0, 1);  // within reach
  const EffectEntry& margin = *find_effect("margin");
  scene.effects.push_back({"margin", Parameters(margin.parameters, {}, "test")});
  const std::weak_ptr<const SignedSurface> shared = scene.bones[0].kept_signed_distance();
  const BackendEntry& entry = find_backend("null");
  const BuiltBackend built = build_backend({scene, entry, Parameters(entry.parameters, {}, entry.name)});
  EXPECT_FALSE(shared.expired()) << "a stage would build it again";
  EXPECT_EQ(scene.bones[0].shared.reused_build_ns(), 0) << "a backend that asks for nothing pays for nothing";
  {
    const PreparedSimulation prepared = prepare_simulation(scene, *built.backend, {entry.default_response}, 1);
    EXPECT_EQ(scene.bones[0].kept_signed_distance(), shared.lock());
    release_shared(scene);
    EXPECT_FALSE(shared.expired()) << "the margin's";
  }
  EXPECT_TRUE(shared.expired());
}

class NoContacts final : public CollisionBackend {
 public:
  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }

 private:
  void do_build() override {}
  void do_detect(std::span<const Vec3> /*positions*/, std::span<const int> /*nodes*/,
                 std::vector<Contact>& /*contacts*/) override {}
};

/// Whether each frame is marked; as many of them as by default, unless told.
std::vector<bool> warm_up_of(int frames, std::optional<int> warm_up_frames = {}) {
  Scene scene;
  scene.add_muscle("muscle", make_sphere(0.1, 0));
  scene.loop.frames = frames;
  const BackendEntry entry{
      .name = "none", .help = "", .make = [](const Parameters& /*none*/) { return std::make_unique<NoContacts>(); }};
  RunCase run{{scene, entry, Parameters({}, {}, entry.name)}};
  run.judge = false;
  run.warm_up_frames = warm_up_frames.value_or(run.warm_up_frames);
  std::vector<bool> marked;
  for (const StepRecord& record : run_case(run, [](int /*frames*/) {}).records) {
    marked.push_back(record.warm_up);
  }
  return marked;
}

TEST(RunCase, MarksTheFirstFramesAsWarmUp) {
  EXPECT_EQ(warm_up_of(4), (std::vector<bool>{true, true, false, false}));
  EXPECT_EQ(warm_up_of(3, 0), (std::vector<bool>{false, false, false}));
  EXPECT_EQ(warm_up_of(2, 5), (std::vector<bool>{true, true}));
}

}  // namespace
}  // namespace musclebench
