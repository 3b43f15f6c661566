// The state hashes of three small scenes for each preset, backend, number of threads and SIMD target, against those in
// golden_states.txt: whoever changes what a simulation computes, down to the last bit, learns it here.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include "bench/cases/run_case.hpp"
#include "bench/cases/tests/pressed_ball.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/read_scene.hpp"
#include "datasets/embedded/embedded_files.hpp"

namespace musclebench {
namespace {

constexpr std::array thread_counts = {1, 2, 3};  // more than cores: each wait costs switches
constexpr const char* renew_variable = "MUSCLEBENCH_RENEW_GOLDEN_STATES";
/// For what differs between processes, not between threads or targets.
constexpr const char* plain_variable = "MUSCLEBENCH_GOLDEN_STATES_OF_ONE_THREAD";

constexpr std::int64_t golden_frames = 6;
constexpr std::int64_t frames_of_a_target = 2;

/// A bar with fibres between two blocks, one of which bends it over a pulley.
constexpr const char* bent_bar = R"(
[[bone]]
name = "foot"
mesh = "synthetic:foot"

[[bone]]
name = "head"
mesh = "synthetic:head"
[bone.motion]
axis = [0, 1, 0]
centre_m = [0, 0, 0]
from_deg = 0
to_deg = 40
course = "there"

[[bone]]
name = "pulley"
mesh = "synthetic:pulley"

[muscle]
name = "bar"
mesh = "synthetic:bar"
fibres = "between_attachments"

[[attachment]]
name = "origin"
bone = "foot"
outline_m = [[-0.01, -0.01, -0.0385], [0.01, -0.01, -0.0385], [0.01, 0.01, -0.0385], [-0.01, 0.01, -0.0385]]
distance_m = 0.003

[[attachment]]
name = "insertion"
bone = "head"
outline_m = [[-0.01, -0.01, 0.0385], [0.01, -0.01, 0.0385], [0.01, 0.01, 0.0385], [-0.01, 0.01, 0.0385]]
distance_m = 0.003
)";

/// With all that acts on contacts.
constexpr const char* leaning = R"(
[[attachment]]
name = "other foot"
bone = "plate"
muscle = "other"
outline_m = [[-0.0399, -0.01, 0], [-0.03, -0.01, 0], [-0.03, 0.01, 0], [-0.0399, 0.01, 0]]
distance_m = 0.002
[effects.margin]
[effects.friction]
[effects.tunnelling_guard]
)";

std::string text_of(const std::string& name) {
  if (name == "bent_bar") return bent_bar;
  if (name == "pressed_ball") return plate_and_rod(-30) + one_ball + foot_of_ball;
  return plate_and_rod(-60) + two_balls + foot_of_ball + leaning;
}

TriangleMesh mesh_of(const std::string& name) {
  const std::map<std::string, TriangleMesh> of_bar = {
      {"foot", displaced(make_box(Vec3(0.02, 0.02, 0.005), 2), Vec3(0, 0, -0.0435))},
      {"head", displaced(make_box(Vec3(0.02, 0.02, 0.005), 2), Vec3(0, 0, 0.0435))},
      {"pulley", displaced(make_sphere(0.01, 3), Vec3(0.018, 0, 0.018))},
      {"bar", make_capsule(0.008, 0.03, 16)},
  };
  return of_bar.contains(name) ? of_bar.at(name) : pressed_ball_mesh(name);
}

Scene load(const std::string& name, const std::string& preset, std::int64_t frames = golden_frames) {
  SceneRequest request;
  request.name = request.file = name;
  request.text = text_of(name);
  request.preset_override = preset;
  request.preset_text = [](const std::string& wanted) {
    const auto presets = embedded_presets();
    const auto found =
        std::find_if(presets.begin(), presets.end(), [&](const EmbeddedFile& file) { return file.name == wanted; });
    return std::string(found->text);
  };
  request.synthetic_mesh = mesh_of;
  request.loop_overrides = {{"frames", frames}, {"substeps", std::int64_t{4}}};
  return read_scene(request);
}

/// Coarse where a backend has a resolution: the bits are what matters.
Parameters coarse_parameters(const BackendEntry& backend) {
  std::map<std::string, ParameterValue> given;
  for (const ParameterSpec& parameter : backend.parameters) {
    if (parameter.name == "cells") {
      given["cells"] = std::int64_t{16};
    }
  }
  return {backend.parameters, given, backend.name};
}

RunResult run(const Scene& scene, const BackendEntry& backend, int threads) {
  RunCase run{{scene, backend, coarse_parameters(backend), threads, 0}};
  run.colliders = choose_collider_backends({}, scene, backend);
  run.judge = false;
  return run_case(run, [](int /*frames*/) {});
}

bool can_run(const Scene& scene, const BackendEntry& backend) {
  try {
    require_what_effects_need(scene, backend, coarse_parameters(backend), {backend.default_response});
    return true;
  } catch (const InputError&) {
    return false;
  }
}

/// Lines of "key value"; lines that begin with # are kept as they are.
struct GoldenFile {
  std::string head;
  std::map<std::string, std::string> values;

  GoldenFile() {
    std::ifstream file(GOLDEN_STATES_FILE);
    for (std::string line; std::getline(file, line);) {
      const std::size_t split = line.rfind(' ');
      if (line.starts_with('#')) {
        head += line + '\n';
      } else if (split != std::string::npos) {
        values[line.substr(0, split)] = line.substr(split + 1);
      }
    }
  }

  void write() const {
    std::ofstream file(GOLDEN_STATES_FILE);
    file << head;
    for (const auto& [key, value] : values) {
      file << key << ' ' << value << '\n';
    }
  }
};

class GoldenState : public testing::TestWithParam<std::tuple<std::string, std::string>> {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  static void expect_same_for_every_target(const Scene& scene, const BackendEntry& backend, const std::string& key) {
    const std::string of_best = run(scene, backend, 2).state_hash;
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      EXPECT_EQ(run(scene, backend, 2).state_hash, of_best) << key << ": on " << hwy::TargetName(target);
    }
    hwy::SetSupportedTargetsForTest(0);
  }
};

TEST_P(GoldenState, IsThatOfEveryBackendForAnyNumberOfThreadsAndEverySimdTarget) {
  const auto& [scene_name, preset] = GetParam();
  const bool renew = std::getenv(renew_variable) != nullptr;
  const bool plain = std::getenv(plain_variable) != nullptr;
  GoldenFile golden;
  const Scene scene = load(scene_name, preset);
  const Scene short_scene = load(scene_name, preset, frames_of_a_target);
  for (const BackendEntry& backend : backend_registry()) {
    if (!can_run(scene, backend)) continue;
    const std::string key = fmt::format("{} {} {}", scene_name, preset, backend.name);
    std::string of_one_thread;
    for (const int threads : std::span(thread_counts).first(plain ? 1 : thread_counts.size())) {
      const RunResult result = run(scene, backend, threads);
      // Not whether the muscle does well, which is what `suspect` is about.
      EXPECT_TRUE(result.status == "ok" || result.status == "suspect") << key << ": " << result.status;
      of_one_thread = threads == 1 ? result.state_hash : of_one_thread;
      EXPECT_EQ(result.state_hash, of_one_thread) << key << ": " << threads << " threads give another state than one";
    }
    if (!plain) expect_same_for_every_target(short_scene, backend, key);
    if (renew) {
      golden.values[key] = of_one_thread;
    } else if (golden.values.contains(key)) {
      EXPECT_EQ(of_one_thread, golden.values[key])
          << key << ": the simulation ends in another state than it did. A change that is not meant to touch what is "
          << "computed has a defect; one that is renews the states with " << renew_variable
          << "=1 and this program, and its commit says why they change.";
    } else if (std::ranges::any_of(golden.values,
                                   [&](const auto& value) { return value.first.ends_with(" " + backend.name); })) {
      ADD_FAILURE() << key << ": its line is missing; " << renew_variable << "=1 writes it";
    } else {  // a backend from outside the project
      std::cout << key << ": no state is recorded for this backend; " << renew_variable << "=1 does it\n";
    }
  }
  if (renew) {
    golden.write();
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, GoldenState,
                         testing::Combine(testing::Values("bent_bar", "pressed_ball", "leaning_balls"),
                                          testing::Values("paper", "standard")),
                         [](const auto& param_info) {
                           return std::get<0>(param_info.param) + "_" + std::get<1>(param_info.param);
                         });

std::vector<std::pair<const char*, const char*>> scenes_and_presets() {
  std::vector<std::pair<const char*, const char*>> all;
  for (const char* name : {"bent_bar", "pressed_ball", "leaning_balls"}) {
    for (const char* preset : {"paper", "standard"}) all.emplace_back(name, preset);
  }
  return all;
}

/// A scene in which nothing is touched would hold no backend to anything.
TEST(GoldenScenes, AskForContacts) {
  for (const auto& [name, preset] : scenes_and_presets()) {
    const Scene scene = load(name, preset);
    std::vector<std::string> idle;
    for (const BackendEntry& backend : backend_registry()) {
      if (!can_run(scene, backend)) continue;
      int contacts = 0;
      int muscle_contacts = 0;
      for (const StepRecord& record : run(scene, backend, 1).records) {
        contacts += record.contacts;
        muscle_contacts += record.muscle_contacts.value_or(0);
      }
      EXPECT_EQ(muscle_contacts > 0, scene.muscles.size() > 1) << name << ": " << backend.name;
      if (contacts < 4) {
        idle.push_back(backend.name);
      }
    }
    // The one that finds none.
    EXPECT_LE(idle.size(), 1U) << name << ' ' << preset << ": " << fmt::format("{}", fmt::join(idle, ", "));
  }
}

}  // namespace
}  // namespace musclebench
