// A bone that no muscle is expected to touch gets no structure, comes back when one does, and no bit depends on it.
#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bench/cases/run_case.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/prepare_simulation.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

/// A ball between a plate that holds it and a rod that presses into it; a block stands far away.
constexpr const char* pressed_beside_block = R"(
[loop]
frames = 6
substeps = 4
time_step_s = 1e-3
[[bone]]
name = "plate"
mesh = "synthetic:plate"
[[bone]]
name = "block"
mesh = "synthetic:block"
[[bone]]
name = "rod"
mesh = "synthetic:rod"
[bone.motion]
axis = [0, 1, 0]
centre_m = [0.05, 0, 0]
from_deg = 0
to_deg = -30
course = "there"
[muscle]
name = "ball"
mesh = "synthetic:ball"
[[attachment]]
name = "foot"
bone = "plate"
outline_m = [[-0.01, -0.01, 0], [0.01, -0.01, 0], [0.01, 0.01, 0], [-0.01, 0.01, 0]]
distance_m = 0.002
)";

/// A ball that nothing holds falls on a plate far below it.
constexpr const char* falling = R"(
[loop]
frames = 40
substeps = 2
time_step_s = 1.5e-3
[[bone]]
name = "plate"
mesh = "synthetic:plate"
[muscle]
name = "ball"
mesh = "synthetic:high_ball"
)";

constexpr const char* plain_effects = "[effects.gravity]\n[effects.edge_length]\n";
constexpr const char* contact_effects =
    "[effects.margin]\n[effects.friction]\n[effects.surface_contact]\n[effects.tunnelling_guard]\n";

TriangleMesh moved_to(TriangleMesh mesh, const Vec3& by_m) {
  for (Vec3& vertex : mesh.vertices) vertex += by_m;
  return mesh;
}

std::string pressed_beside_long_rod() {
  std::string text = pressed_beside_block;
  const std::string rod = "synthetic:rod";
  return text.replace(text.find(rod), rod.size(), "synthetic:long_rod");
}

/// Its lower end is where the rod's is; it leans, so that it touches the sides of its box at its ends only.
TriangleMesh long_rod() {
  const Vec3 end(0.034, 0, 0.02);
  const RigidMotion lean = RigidMotion::about_axis(Vec3(1, -1, 0).normalized(), end, 0.5);
  TriangleMesh mesh = moved_to(make_capsule(0.01, 0.2, 16), Vec3(0.034, 0, 0.2));
  for (Vec3& vertex : mesh.vertices) vertex = lean.apply(vertex);
  return mesh;
}

TriangleMesh mesh_named(const std::string& name) {
  if (name == "long_rod") return long_rod();
  if (name == "plate") return moved_to(make_box(Vec3(0.04, 0.04, 0.01), 4), Vec3(0, 0, -0.01));
  if (name == "block") return moved_to(make_box(Vec3(0.04, 0.04, 0.01), 4), Vec3(0.5, 0, 0));
  if (name == "rod") return moved_to(make_capsule(0.01, 0.02, 16), Vec3(0.034, 0, 0.03));
  return moved_to(make_sphere(0.02, 2), Vec3(0, 0, name == "ball" ? 0.0205 : 0.06));
}

Scene read(const std::string& text) {
  SceneRequest request;
  request.name = request.file = "pruning.toml";
  request.text = text;
  request.synthetic_mesh = mesh_named;
  return read_scene(request);
}

/// Coarse where a backend has a resolution: the bits are what matters.
RunCase case_of(const Scene& scene, const BackendEntry& backend, int threads, bool prune) {
  std::map<std::string, ParameterValue> given;
  for (const ParameterSpec& parameter : backend.parameters) {
    if (parameter.name == "cells") given["cells"] = std::int64_t{16};
  }
  RunCase run{{scene, backend, Parameters(backend.parameters, given, backend.name), threads}};
  run.responses = {backend.default_response};
  run.judge = false;
  run.prune = prune;
  return run;
}

RunResult result_of(const RunCase& run) {
  return run_case(run, [](int /*frames*/) {});
}

int contacts_of(const RunResult& result) {
  int contacts = 0;
  for (const StepRecord& record : result.records) contacts += record.contacts;
  return contacts;
}

bool is_served(const Scene& scene, const BackendEntry& backend) {
  try {
    const RunCase run = case_of(scene, backend, 1, true);
    require_what_effects_need(scene, backend, run.parameters, run.responses);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

/// Whether the backend could prune bones of the scene if all were expected untouched.
bool can_prune(const Scene& scene, const BackendEntry& backend) {
  const RunCase run = case_of(scene, backend, 1, true);
  const auto made = backend.make(run.parameters);
  made->expect_within(std::vector<Eigen::AlignedBox3d>(scene.bones.size()));
  made->build(scene.bones, scene.muscle_mesh, 1);
  return !made->pruned_bones().empty();
}

TEST(Pruning, AFarBoneIsInNoStructureAndNoBitDependsOnIt) {
  for (const char* effects : {"", contact_effects}) {
    const Scene scene = read(std::string(pressed_beside_block) + plain_effects + effects);
    int pruned_by = 0;
    for (const BackendEntry& backend : backend_registry()) {
      if (!is_served(scene, backend)) continue;
      const RunResult whole = result_of(case_of(scene, backend, 1, false));
      EXPECT_TRUE(whole.pruned.empty()) << backend.name;
      for (int threads = 1; threads <= (std::string(effects).empty() ? 2 : 1); ++threads) {
        const RunResult result = result_of(case_of(scene, backend, threads, true));
        EXPECT_EQ(result.state_hash, whole.state_hash) << backend.name << " on " << threads;
        EXPECT_EQ(contacts_of(result), contacts_of(whole)) << backend.name;
        if (result.pruned.empty()) continue;
        ++pruned_by;
        ASSERT_EQ(result.pruned.size(), 1U) << backend.name;
        const PrunedResult& block = result.pruned.front();
        EXPECT_EQ(scene.bones[static_cast<std::size_t>(block.pruned.bone)].name, "block");
        EXPECT_FALSE(block.frame_back) << backend.name;
        EXPECT_GT(block.pruned.saved_queries, 24 * 150) << backend.name;
        EXPECT_GT(block.reach.distance_m, block.reach.margin_m);
        EXPECT_EQ(result.structure_bytes<whole.structure_bytes, whole.structure_bytes> 0) << backend.name;
      }
    }
    EXPECT_GT(pruned_by, 0);
  }
}

TEST(Pruning, AMuscleThatFliesFartherThanExpectedBringsTheBoneBack) {
  for (const char* effects : {"", contact_effects}) {
    const Scene scene = read(std::string(falling) + plain_effects + effects);
    for (const BackendEntry& backend : backend_registry()) {
      if (!is_served(scene, backend) || !can_prune(scene, backend)) continue;
      const RunResult whole = result_of(case_of(scene, backend, 1, false));
      EXPECT_GT(contacts_of(whole), 10) << backend.name << ": the ball does not arrive";
      for (int threads = 1; threads <= (std::string(effects).empty() ? 2 : 1); ++threads) {
        const RunResult result = result_of(case_of(scene, backend, threads, true));
        EXPECT_EQ(result.state_hash, whole.state_hash) << backend.name << " on " << threads;
        ASSERT_EQ(result.pruned.size(), 1U) << backend.name;
        ASSERT_TRUE(result.pruned.front().frame_back) << backend.name;
        EXPECT_GT(*result.pruned.front().frame_back, 5) << backend.name;
        EXPECT_GT(result.pruned.front().pruned.build_ns, 0) << backend.name;
        EXPECT_EQ(result.structure_bytes, whole.structure_bytes) << backend.name;
      }
    }
  }
}

struct Outcome {
  std::vector<Vec3> positions;
  std::vector<PrunedBone> pruned;
};

/// Of a run where nodes are expected within this box of each bone's rest frame.
Outcome outcome_where(const Scene& scene, const BackendEntry& backend, const Eigen::AlignedBox3d& expected) {
  const RunCase run = case_of(scene, backend, 1, false);
  const auto made = make_backend(scene, backend, run.parameters, run.colliders);
  made->expect_within(std::vector<Eigen::AlignedBox3d>(scene.bones.size(), expected));
  made->build(scene.bones, scene.muscle_mesh, run.threads);
  const PreparedSimulation prepared = prepare_simulation(scene, *made, run.responses, run.threads);
  for (int frame = 1; frame <= scene.loop.frames; ++frame) prepared.simulation->step_frame(frame);
  return {prepared.simulation->positions(), made->pruned_bones()};
}

/// Whether a part of what it builds may do: grids of libraries are built whole.
bool builds_parts(const BackendEntry& backend) {
  return backend.implementation.starts_with("this project") &&
         std::ranges::any_of(backend.parameters,
                             [](const auto& each) { return each.role == ParameterRole::resolution; });
}

/// However wrong the expectation is, with bones that move in and stages that keep surfaces of their own.
TEST(Pruning, AWrongExpectationCostsNoBit) {
  std::int64_t completed = 0;
  for (const char* effects : {"", contact_effects, "[effects.tunnelling_guard]\nrule = \"angle\"\n"}) {
    for (const char* text : {pressed_beside_block, falling}) {
      const Scene scene = read(std::string(text) + plain_effects + effects);
      for (const BackendEntry& backend : backend_registry()) {
        if (!is_served(scene, backend)) continue;
        const Outcome whole = outcome_where(scene, backend, unbounded_box());
        EXPECT_TRUE(whole.pruned.empty());
        const Outcome untouched = outcome_where(scene, backend, Eigen::AlignedBox3d());
        EXPECT_EQ(untouched.positions, whole.positions) << backend.name << " with " << effects;
        for (const PrunedBone& pruned : untouched.pruned) {
          const std::string& name = scene.bones[static_cast<std::size_t>(pruned.bone)].name;
          EXPECT_EQ(pruned.is_back, name != "block") << backend.name << ": " << name;
        }
        // Across the bones of both scenes, and the places where the ball touches them.
        const Outcome in_part = outcome_where(scene, backend, {Vec3(0.002, -0.1, -0.1), Vec3(0.1, 0.1, 0.1)});
        EXPECT_EQ(in_part.positions, whole.positions) << backend.name << " with " << effects;
        EXPECT_EQ(in_part.pruned.empty(), !builds_parts(backend)) << backend.name;
        completed += std::ranges::count(in_part.pruned, true, &PrunedBone::is_back);
      }
    }
  }
  EXPECT_GT(completed, 0) << "no node came where none was expected";
}

/// The rod turns about the ball's side, so that its far end is out of reach.
TEST(Pruning, OfAGridThePartInReachIsBuiltAndNoBitDependsOnIt) {
  const Scene scene = read(std::string(pressed_beside_long_rod()) + plain_effects);
  int with_grids = 0;
  for (const BackendEntry& backend : backend_registry()) {
    if (!is_served(scene, backend)) continue;
    const RunResult whole = result_of(case_of(scene, backend, 1, false));
    for (const int threads : {1, 2}) {
      const RunResult result = result_of(case_of(scene, backend, threads, true));
      EXPECT_EQ(result.state_hash, whole.state_hash) << backend.name << " on " << threads;
      const auto rod = std::ranges::find_if(result.pruned, [](const auto& each) { return each.pruned.kept_share > 0; });
      if (rod == result.pruned.end()) continue;
      ++with_grids;
      EXPECT_EQ(scene.bones[static_cast<std::size_t>(rod->pruned.bone)].name, "rod");
      EXPECT_LT(rod->pruned.kept_share, 0.5) << backend.name;
      EXPECT_FALSE(rod->frame_back) << backend.name;
      EXPECT_LT(result.structure_bytes, whole.structure_bytes) << backend.name;
    }
  }
  EXPECT_GE(with_grids, 4) << "two backends, twice";
}

TEST(Pruning, BonesWithBackendsOfTheirOwnArePrunedEach) {
  const Scene scene = read(std::string(pressed_beside_block) + plain_effects);
  RunCase run = case_of(scene, exact_backend(), 1, true);
  run.colliders = choose_collider_backends({"rod=brute_force"}, scene, exact_backend());
  const RunResult pruned = result_of(run);
  run.prune = false;
  EXPECT_EQ(pruned.state_hash, result_of(run).state_hash);
  ASSERT_EQ(pruned.pruned.size(), 1U);
  EXPECT_EQ(scene.bones[static_cast<std::size_t>(pruned.pruned.front().pruned.bone)].name, "block");
}

}  // namespace
}  // namespace musclebench
