// Runs that look sound to whoever asks nodes only: the judge sees what is wrong with each.
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/collider_backends.hpp"
#include "bench/cases/run_case.hpp"
#include "core/mesh/shapes.hpp"
#include "core/referee/tests/test_bones.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

/// Bones swing about a far axis to where they are drawn, 0.2 m from it, and a muscle that nothing moves waits there.
Scene swinging(const std::vector<TriangleMesh>& bones, const TriangleMesh& muscle) {
  constexpr double turn_rad = 1;
  const Vec3 there(0.2, 0, 0);
  Scene scene;
  scene.name = "swinging";
  const RigidMotion start = RigidMotion::about_axis(Vec3::UnitZ(), Vec3::Zero(), turn_rad);
  BoneRotation motion;
  motion.axis = Vec3::UnitZ();
  motion.times = {0, 1};
  motion.angles_rad = {0, -turn_rad};
  motion.there_and_back = false;
  for (const TriangleMesh& bone : bones) {
    scene.bones.push_back(bone_of(moved(moved(bone, there), start)));
    scene.bone_meshes.push_back({"bone", "", scene.bones.back().surface.mesh});
    scene.motions.push_back({{motion}});
  }
  scene.add_muscle("muscle", moved(muscle, there));
  scene.loop.frames = 1;
  scene.loop.substeps = 1000;  // pays for a judgement that leaves nothing open
  return scene;
}

Scene swinging(const TriangleMesh& bone, const TriangleMesh& muscle) { return swinging(std::vector{bone}, muscle); }

RunResult run_with(const Scene& scene, const BackendEntry& backend) {
  return run_case({{scene, backend, Parameters(backend.parameters, {}, backend.name)}}, [](int) {});
}

RunResult run_with_null(const Scene& scene) { return run_with(scene, find_backend("null")); }

void expect_suspect(const RunResult& result, const std::string& words) {
  EXPECT_EQ(result.status, "suspect");
  EXPECT_NE(result.status_detail.find(words), std::string::npos) << result.status_detail;
}

TEST(JudgedRun, ANeedleThroughAFaceIsSuspect) {
  const RunResult result =
      run_with_null(swinging(make_box({0.0005, 0.0005, 0.05}, 8), make_box({0.02, 0.02, 0.02}, 1)));
  expect_suspect(result, "a vertex of the shape is");
  expect_suspect(result, "25 % of the bone's thickness");
  EXPECT_EQ(result.outcome.max_depth_m, 0) << "no node is inside";
  EXPECT_LT(result.records.back().surface_depth_m, 6e-4);
  EXPECT_GT(result.records.back().bone_vertex_depth_m, 0.01);
}

/// The block is deeper and within its limit.
TEST(JudgedRun, ABlockHidesNoNeedle) {
  const TriangleMesh muscle = make_box({0.02, 0.02, 0.02}, 1);
  const TriangleMesh block = moved(make_box({0.01, 0.01, 0.01}, 1), Vec3(0.02 + 0.01 - 0.00025, 0, 0));
  const TriangleMesh needle = moved(make_box({0.0005, 0.0005, 0.02}, 8), Vec3(0, 0, 0.02 + 0.02 - 0.0002));
  EXPECT_EQ(run_with_null(swinging(block, muscle)).status, "ok");
  // Thin, too, but not as thin: it may be 0.3 mm deep.
  const TriangleMesh blade = moved(make_box({0.0007, 0.01, 0.01}, 1), Vec3(0, 0, -(0.02 + 0.01 - 0.00022)));
  EXPECT_EQ(run_with_null(swinging({block, blade}, muscle)).status, "ok");
  const RunResult result = run_with_null(swinging({block, blade, needle}, muscle));
  EXPECT_NEAR(*result.outcome.max_surface_depth_m, 0.00025, 1e-6);
  expect_suspect(result, "0.2 mm deep");
  expect_suspect(result, "25 % of the bone's thickness");
}

TEST(JudgedRun, ABallDeepInACoarseMuscleIsSuspect) {
  const RunResult result = run_with_null(swinging(make_sphere(0.006, 2), make_box({0.02, 0.02, 0.02}, 1)));
  EXPECT_GT(result.outcome.max_surface_depth_m, 0.0148);
  EXPECT_LT(result.outcome.max_surface_depth_m, result.rest.mean_edge_length_m) << "less than one edge";
  EXPECT_EQ(result.outcome.max_depth_m, 0);
  expect_suspect(result, "mm deep in the muscle");
}

TEST(JudgedRun, WhatNoBackendHoldsIsSuspectAtFiveMillimetres) {
  const RunResult result =
      run_with_null(swinging(make_sphere(0.05, 4), moved(make_sphere(0.05, 3), Vec3(0.0955, 0, 0))));
  EXPECT_NEAR(*result.outcome.max_depth_m, 0.0045, 0.0005);
  expect_suspect(result, "mm deep in the shape at -57 degrees (frame 1) (limit");
  expect_suspect(result, "null missed");
}

TEST(JudgedRun, TheSameMeshTwiceIsSuspect) {
  const TriangleMesh ball = moved(make_sphere(0.05, 2), Vec3(0.5, 0, 0));
  Scene scene = swinging(make_sphere(0.01, 1), ball);
  scene.add_muscle("twin", moved(ball, Vec3(0.2, 0, 0)));
  const RunResult result = run_with_null(scene);
  expect_suspect(result, "100 % of the triangles of muscle are those of twin");
  EXPECT_EQ(result.outcome.muscle_crossings_at_rest, 0) << "triangles that coincide touch";
}

/// Holds nothing, and declares what it may miss.
class Forgetful final : public CollisionBackend {
 public:
  explicit Forgetful(double declared_m) : m_declared_m(declared_m) {}
  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {m_declared_m}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }

 private:
  void do_build() override {}
  void do_detect(std::span<const Vec3> /*positions*/, std::span<const int> /*nodes*/,
                 std::vector<Contact>& /*contacts*/) override {}
  double m_declared_m;
};

TEST(JudgedRun, ABackendThatMissesMoreThanItDeclaresIsSuspect) {
  // 0.1 mm deep: within every limit of a depth.
  const Scene scene = swinging(make_sphere(0.05, 4), moved(make_sphere(0.05, 3), Vec3(0.0999, 0, 0)));
  const auto with = [&](double declared_m) {
    const BackendEntry entry{.name = "forgetful", .help = "", .make = [=](const Parameters& /*none*/) {
                               return std::make_unique<Forgetful>(declared_m);
                             }};
    return run_with(scene, entry);
  };
  const RunResult exact = with(0);
  EXPECT_GT(exact.outcome.missed_beyond, 0);
  EXPECT_EQ(exact.outcome.missed_beyond, exact.outcome.true_contacts);
  EXPECT_GT(exact.outcome.max_missed_m, 1e-5);
  expect_suspect(exact, "forgetful missed");
  EXPECT_EQ(exact.status_detail.find(" deep in"), std::string::npos) << exact.status_detail;
  expect_suspect(with(std::numeric_limits<double>::infinity()), "forgetful missed");
  const RunResult coarse = with(1e-3);
  EXPECT_EQ(coarse.outcome.missed_beyond, 0);
  EXPECT_EQ(coarse.status, "ok") << coarse.status_detail;
}

/// Two muscles above each other that fly towards each other.
RunResult collided(const TriangleMesh& lower, const TriangleMesh& upper, double speed_m_per_s, double time_step_s,
                   int frames, bool touch = true) {
  SceneRequest request;
  request.name = request.file = "test.toml";
  request.text = fmt::format(R"(
[loop]
frames = {}
substeps = 10
time_step_s = {}
density_kg_per_m3 = 1000.0
[effects.edge_length]
[effects.volume]
[[bone]]
name = "far"
mesh = "synthetic:far"
[[muscle]]
name = "lower"
mesh = "synthetic:lower"
velocity_m_per_s = [0, 0, {}]
[[muscle]]
name = "upper"
mesh = "synthetic:upper"
velocity_m_per_s = [0, 0, {}]
[contact]
muscle_contact = {}
)",
                             frames, time_step_s, speed_m_per_s / 2, -speed_m_per_s / 2, touch);
  request.synthetic_mesh = [&](const std::string& name) {
    if (name == "far") return moved(make_sphere(0.01, 1), Vec3(5, 5, 5));
    return name == "lower" ? lower : upper;
  };
  const Scene scene = read_scene(request);
  const BackendEntry& entry = find_backend("bvh");
  RunCase run{{scene, entry, Parameters(entry.parameters, {}, "test")}};
  run.colliders = choose_collider_backends({}, scene, entry);
  return run_case(run, [](int) {});
}

/// A square bar along `axis`, on its edge.
TriangleMesh bar_on_edge(int cells, int axis) {
  const Vec3 along = axis == 0 ? Vec3::UnitX() : Vec3::UnitY();
  Vec3 half_m = Vec3::Constant(0.005);
  half_m[axis] = 0.03;
  const TriangleMesh bar = make_box(half_m, cells);
  return moved(bar, RigidMotion::about_axis(along, Vec3::Zero(), std::numbers::pi / 4));
}

TEST(JudgedRun, BarsCrossedEdgeOnEdgeAreSuspect) {
  const double gap_m = 2 * 0.005 * std::numbers::sqrt2 + 0.0005;
  const RunResult result =
      collided(bar_on_edge(2, 0), moved(bar_on_edge(2, 1), Vec3(0.0007, 0.0003, gap_m)), 0.2, 1e-3, 4);
  EXPECT_LT(*result.outcome.max_muscle_depth_m, 1e-4) << "nodes stay outside";
  EXPECT_GT(result.outcome.muscle_crossings, 3);
  EXPECT_GT(result.outcome.max_muscle_surface_depth_m, 1e-3);
  EXPECT_EQ(result.outcome.muscle_crossings_at_rest, 0);
  expect_suspect(result, "because contact between muscles acts at nodes");
}

TEST(JudgedRun, WhatOverlapsAtRestIsNoExcuseForPassingElsewhere) {
  const TriangleMesh bar = make_box({0.004, 0.02, 0.05}, 12);
  const TriangleMesh ball = moved(make_sphere(0.014, 2), Vec3(0.01, 0.0003, 0.03));
  const RunResult at_rest = collided(bar, ball, 0, 1e-3, 3, false);
  EXPECT_EQ(at_rest.status, "ok") << at_rest.status_detail;
  EXPECT_GT(at_rest.outcome.muscle_crossings_at_rest, 17) << "more than one of a hundred";
  const RunResult slid = collided(bar, ball, 2, 1e-3, 3, false);
  EXPECT_LE(slid.records.back().muscle_crossings, *slid.outcome.muscle_crossings_at_rest + 17);
  expect_suspect(slid, "of the triangles of lower pass through upper");
}

TEST(JudgedRun, SpheresThatChangeSidesUntouchedAreSuspect) {
  const TriangleMesh ball = make_sphere(0.02, 2);
  const RunResult result = collided(ball, moved(ball, Vec3(0, 0, 0.5)), 100, 1e-3, 2);
  EXPECT_EQ(result.outcome.nodes_inside_muscles, 0);
  EXPECT_EQ(result.outcome.muscle_crossings, 0);
  EXPECT_GT(result.outcome.passed_nodes, 50);
  expect_suspect(result, "nodes went through another muscle between two frames in frame 1");
  const RunResult beside = collided(ball, moved(ball, Vec3(0.05, 0, 0.5)), 100, 1e-3, 2);
  EXPECT_EQ(beside.outcome.passed_nodes, 0);
  EXPECT_EQ(beside.status, "ok") << beside.status_detail;
}

}  // namespace
}  // namespace musclebench
