// What a command line does: options and what is wrong with them, messages of one line, exit codes. What commands
// compute is tested where it stands.
#include "bench/commands/command_line.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "bench/cases/tests/pressed_ball.hpp"
#include "bench/process/exit_code.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/mesh_files/read_mesh.hpp"

namespace musclebench {
namespace {

namespace fs = std::filesystem;

/// A run of the program in this process.
struct Done {
  int exit_code = 0;
  std::string out;
  std::string errors;

  /// Refused in one line that holds all of `words`, with nothing else said.
  void expect_refused(const std::vector<std::string>& words) const {
    EXPECT_EQ(exit_code, exit_bad_input) << errors;
    EXPECT_EQ(std::ranges::count(errors, '\n'), 1) << errors;
    for (const std::string& word : words) EXPECT_NE(errors.find(word), std::string::npos) << word << ": " << errors;
  }
  [[nodiscard]] bool says(const std::string& words) const { return out.find(words) != std::string::npos; }
  [[nodiscard]] bool complains_of(const std::string& words) const { return errors.find(words) != std::string::npos; }
};

Done call(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "musclebench");
  std::vector<const char*> argv;
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Done done;
  done.exit_code = run_command_line(static_cast<int>(argv.size()), argv.data());
  done.out = testing::internal::GetCapturedStdout();
  done.errors = testing::internal::GetCapturedStderr();
  return done;
}

/// A folder with a scene of its own files: a ball that is attached to a plate and pressed by a rod.
class CommandLine : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"plate", "rod", "ball"}) {
      write_ply(pressed_ball_mesh(name), m_folder / fmt::format("{}.ply", name));
    }
    write_scene(loop);
  }

  void write_scene(const std::string& more) const {
    std::string text = plate_and_rod(-30) + one_ball + foot_of_ball + more;
    for (const std::string name : {"plate", "rod", "ball"}) {
      const std::string synthetic = "synthetic:" + name;
      text.replace(text.find(synthetic), synthetic.size(), name + ".ply");
    }
    std::ofstream(m_folder / "scene.toml") << text;
  }

  [[nodiscard]] std::string scene() const { return (m_folder / "scene.toml").string(); }
  [[nodiscard]] std::string path(const std::string& name) const { return (m_folder / name).string(); }

  /// `musclebench run` of the scene into `out`.
  [[nodiscard]] Done run(const std::vector<std::string>& more, const std::string& backend = "null") const {
    std::vector<std::string> arguments = {"run", scene(), "--backend", backend, "--out", path("out")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  }
  [[nodiscard]] nlohmann::json manifest() const {
    std::ifstream file(m_folder / "out" / "run.json");
    return nlohmann::json::parse(file);
  }

  static constexpr const char* loop = "[loop]\nframes = 2\nsubsteps = 2\n[effects.edge_length]\n[effects.attachment]\n";
  TemporaryFolder m_folder;
};

TEST_F(CommandLine, WithoutACommandIsRefused) {
  call({}).expect_refused({"subcommand", "--help"});
  call({"rnu"}).expect_refused({"'rnu' is no command", "'run'"});
  run({"--fraems", "3"}).expect_refused({"'--fraems'", "'--frames'"});
}

TEST_F(CommandLine, HelpAndVersionGoToStandardOutput) {
  for (const char* option : {"--help", "--version"}) {
    const Done done = call({option});
    EXPECT_EQ(done.exit_code, 0);
    EXPECT_TRUE(done.says("musclebench")) << done.out;
    EXPECT_TRUE(done.errors.empty());
  }
  EXPECT_TRUE(call({"run", "--help"}).says("--snapshots"));
}

TEST_F(CommandLine, ARunIsWrittenAndTheSecondTimeFound) {
  const Done first = run({});
  EXPECT_EQ(first.exit_code, 0) << first.errors;
  EXPECT_TRUE(first.says("written to " + path("out"))) << first.out;
  EXPECT_EQ(manifest()["status"], "suspect") << "the rod goes into the ball, and null lets it";
  EXPECT_TRUE(run({}).says("complete already"));
  EXPECT_FALSE(run({"--force"}).says("complete already"));
  run({"--frames", "3"}).expect_refused({path("out"), "--force"});
}

TEST_F(CommandLine, OptionsOfTheSceneReachTheRun) {
  ASSERT_EQ(run({"--frames", "3", "--loop", "substeps=1", "--snapshots", "9,0"}).exit_code, 0);
  EXPECT_EQ(manifest()["case"]["loop"]["frames"], 3) << manifest();
  EXPECT_EQ(manifest()["case"]["loop"]["substeps"], 1);
  EXPECT_TRUE(fs::exists(m_folder / "out" / "frames.csv"));
  const Done warned = run({"--frames", "3", "--snapshots", "9", "--force"});
  EXPECT_TRUE(warned.complains_of("frame 9 is not among the 3 frames")) << warned.errors;
}

TEST_F(CommandLine, WhatNoRunCanDoIsRefusedBeforeItsFirstFrame) {
  run({"--frames", "0"}).expect_refused({"--frames"});
  run({"--threads", "100000"}).expect_refused({"--threads"});
  run({"--threads", "4000"}).expect_refused({"--threads", "cores of this machine"});
  run({"--loop", "substep=2"}).expect_refused({"--loop", "substeps"});
  run({"--loop", "substeps=two"}).expect_refused({"--loop", "substeps"});
  run({"--param", "cells=8"}).expect_refused({"--param", "cells"});
  run({}, "nul").expect_refused({"nul", "null"});
  run({"--response", "push"}).expect_refused({"push", "project"});
  run({"--for", "thumb=null"}).expect_refused({"--for", "thumb", "plate"});
  run({"--preset", "papr"}).expect_refused({"papr", "paper"});
  run({"--strict", "--no-referee"}).expect_refused({"--strict", "--no-referee"});
  run({"--snapshots", "-1"}).expect_refused({"--snapshots"});
  EXPECT_FALSE(fs::exists(path("out")));
  call({"run", path("missing.toml"), "--backend", "null"}).expect_refused({"missing.toml"});
  call({"run", scene()}).expect_refused({"--backend"});
}

/// A muscle that hangs from its foot and is torn: `suspect`, which only --strict makes a failure, also when the result
/// is there already.
TEST_F(CommandLine, StrictTurnsASuspectRunIntoAFailure) {
  write_scene(std::string(loop) + "[effects.gravity]\nz_m_per_s2 = 2e4\n");
  const Done lenient = run({});
  EXPECT_EQ(lenient.exit_code, 0);
  EXPECT_TRUE(lenient.complains_of("suspect: ")) << lenient.out;
  EXPECT_EQ(manifest()["status"], "suspect");
  const Done strict = run({"--strict"});
  EXPECT_TRUE(strict.says("complete already"));
  EXPECT_EQ(strict.exit_code, exit_not_held);
  EXPECT_TRUE(strict.complains_of("suspect: "));
}

TEST_F(CommandLine, ARunThatDivergesHasAnExitCodeOfItsOwn) {
  write_scene(std::string(loop) + "[effects.gravity]\nz_m_per_s2 = 1e6\n");
  const Done done = run({"--loop", "time_step_s=1"});
  EXPECT_EQ(done.exit_code, exit_diverged) << done.out << done.errors;
  EXPECT_TRUE(done.complains_of("diverged: ")) << done.errors;
}

TEST_F(CommandLine, CheckTellsOverlapsOfFreeAndAttachedNodesApart) {
  std::string text;
  {
    std::ifstream file(scene());
    text.assign(std::istreambuf_iterator<char>(file), {});
  }
  const Done apart = call({"check", scene()});
  EXPECT_EQ(apart.exit_code, 0);
  EXPECT_TRUE(apart.says("overlap with plate at rest: 0 of ")) << apart.out;
  EXPECT_TRUE(apart.says("no defects"));
  // The ball sinks 1 mm into the plate: its foot, which is attached, and some nodes beside it.
  write_ply(displaced(pressed_ball_mesh("ball"), Vec3(0, 0, -0.0025)), m_folder / "ball.ply");
  std::ofstream(scene()) << text.replace(text.find("-0.01, -0.01, 0"), 15, "-0.001, -0.001, 0")
                                .replace(text.find("[0.01, -0.01, 0], [0.01, 0.01, 0], [-0.01, 0.01, 0]"), 51,
                                         "[0.001, -0.001, 0], [0.001, 0.001, 0], [-0.001, 0.001, 0]");
  const Done sunk = call({"check", scene()});
  EXPECT_EQ(sunk.exit_code, 0);
  const std::size_t line = sunk.out.find("overlap with plate at rest: ");
  ASSERT_NE(line, std::string::npos);
  const std::string told = sunk.out.substr(line, sunk.out.find('\n', line) - line);
  int free = 0;
  int of_free = 0;
  int attached = 0;
  int of_attached = 0;
  double free_mm = 0;
  double attached_mm = 0;
  ASSERT_EQ(std::sscanf(told.c_str(),
                        "overlap with plate at rest: %d of %d free nodes inside, %lf mm deep; %d of %d attached nodes "
                        "inside, %lf mm deep",
                        &free, &of_free, &free_mm, &attached, &of_attached, &attached_mm),
            6)
      << told;
  EXPECT_GT(free, 0);
  EXPECT_GT(attached, 0);
  EXPECT_EQ(of_free + of_attached, static_cast<int>(pressed_ball_mesh("ball").vertices.size()));
  EXPECT_GT(attached_mm, free_mm);  // the lowest node is the foot's
  EXPECT_TRUE(sunk.says(fmt::format("{} of 162 nodes begin inside bone 'plate' without being bound", free)))
      << "the warning counts others: " << sunk.out;
}

TEST_F(CommandLine, CheckTakesAMeshOrTheNameOfAScene) {
  EXPECT_TRUE(call({"check", path("ball.ply")}).says("no defects"));
  call({"check", path("none.ply")}).expect_refused({"none.ply"});
  call({"check", "synthetic/ilacus"}).expect_refused({"synthetic/iliacus"});
}

TEST_F(CommandLine, ListSpeaksToPeopleAndToPrograms) {
  const Done people = call({"list"});
  for (const char* word : {"Backends", "Responses", "Effects", "Presets", "Scenes", "time_step_s"}) {
    EXPECT_TRUE(people.says(word)) << word;
  }
  const nlohmann::json programs = nlohmann::json::parse(call({"list", "--json"}).out);
  for (const nlohmann::json& backend : programs["backends"]) {
    EXPECT_TRUE(people.says("  " + backend["name"].get<std::string>() + " ")) << backend["name"];
  }
}

TEST_F(CommandLine, FieldNamesBonesAndBackendsThatItCanTake) {
  const std::vector<std::string> field = {"field", scene(), "--out", path("a.field")};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), field.begin(), field.end());
    return call(more);
  };
  with({}).expect_refused({"--bone", "plate, rod"});
  with({"--bone", "thumb"}).expect_refused({"--bone thumb", "plate, rod"});
  with({"--bone", "plate", "--backend", "null"}).expect_refused({"--backend null", "no distance field"});
  const Done done = with({"--bone", "plate", "--param", "cells=8"});
  EXPECT_EQ(done.exit_code, 0) << done.errors;
  EXPECT_TRUE(done.says("plate of ") && fs::exists(path("a.field"))) << done.out;
}

TEST_F(CommandLine, ARecordingIsMadeAndReplayed) {
  const std::vector<std::string> record = {"record", scene(), "--out", path("a.recording")};
  const Done made = call(record);
  EXPECT_EQ(made.exit_code, 0) << made.errors;
  ASSERT_TRUE(fs::exists(path("a.recording"))) << made.out;
  const auto replay = [&](const std::string& file, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"replay", file, "--backend", "null", "--out", path("replayed")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  };
  EXPECT_EQ(replay(path("a.recording"), {}).exit_code, 0);
  EXPECT_TRUE(fs::exists(m_folder / "replayed" / "run.json"));
  replay(path("scene.toml"), {"--force"}).expect_refused({"scene.toml"});
  replay(path("none.recording"), {"--force"}).expect_refused({"none.recording"});
}

TEST_F(CommandLine, ARecordingOfAnotherMotionAndOtherMeshesIsReplayed) {
  const std::string file = path("b.recording");
  const Done made = call({"record", scene(), "--meshes", "split_muscles=1", "--motion", "to_deg=3", "--out", file});
  EXPECT_EQ(made.exit_code, 0) << made.errors;
  const Done done = call({"replay", file, "--backend", "null", "--out", path("replayed")});
  EXPECT_EQ(done.exit_code, 0) << done.errors;
}

TEST_F(CommandLine, VerifyHoldsAboutSoundBones) {
  const Done done = call({"verify", scene(), "--points", "200", "--brute-force-points", "20"});
  EXPECT_EQ(done.exit_code, 0) << done.out;
  EXPECT_TRUE(done.says("\nheld\n")) << done.out;
  call({"verify", scene(), "--points", "0"}).expect_refused({"--points"});
}

/// CLI::Range lets NaN pass.
TEST_F(CommandLine, LengthsArePositiveAndFinite) {
  for (const char* length : {"nan", "inf", "0", "-1", "much"}) {
    call({"advise", scene(), "--depth-mm", length}).expect_refused({"--depth-mm", "positive"});
  }
}

}  // namespace
}  // namespace musclebench
