#include "bench/results/run_output.hpp"

#include <fstream>
#include <optional>
#include <sys/stat.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "bench/results/result_folder.hpp"
#include "bench/results/tests/small_run.hpp"
#include "core/base/temporary_folder.hpp"

namespace musclebench {
namespace {

TEST(RunOutput, ASuspectRunIsComplete) {
  const Scene scene = plain_scene();
  const RunCase run = case_of(scene, "null");
  RunResult result = result_of(run);
  const TemporaryFolder folder;
  const std::filesystem::path out = folder.path() / "out";
  for (const char* status : {"ok", "suspect", "diverged"}) {
    result.status = status;
    write_run(out, run, result);
    EXPECT_EQ(is_complete(out, run_id(run), "frames.csv"), std::string(status) != "diverged") << status;
  }
}

TEST(RunOutput, ACutTableIsNoCompleteRun) {
  const Scene scene = plain_scene();
  const RunCase run = case_of(scene, "null");
  const TemporaryFolder folder;
  const std::filesystem::path out = folder.path() / "out";
  write_run(out, run, result_of(run));
  const std::optional<StoredResult> stored = complete_result(out, run_id(run), "frames.csv");
  ASSERT_TRUE(stored.has_value());
  EXPECT_EQ(stored->status, manifest_in(out)["status"].get<std::string>());
  EXPECT_EQ(stored->status_detail, manifest_in(out)["status_detail"].get<std::string>());
  for (const char* rows : {"", "frame\n", "frame\n1,0\n", "frame\n1,0\n2", "frame\n1,0\n1,0\n"}) {
    std::ofstream(out / "frames.csv") << rows;
    EXPECT_FALSE(is_complete(out, run_id(run), "frames.csv")) << rows;
  }
  std::ofstream(out / "frames.csv") << "frame\n1,0\n2,0\n";
  EXPECT_TRUE(is_complete(out, run_id(run), "frames.csv"));
}

TEST(RunOutput, WhatIsNoFileIsNotRead) {
  const TemporaryFolder folder;
  EXPECT_TRUE(read_manifest(folder.path()).is_null());
  ASSERT_EQ(mkfifo((folder.path() / "run.json").c_str(), 0600), 0);
  EXPECT_TRUE(read_manifest(folder.path()).is_null()) << "opening it would wait for ever";
}

TEST(RunOutput, SaysTheLimitsAndTheMachinesState) {
  const Scene scene = plain_scene();
  const RunCase run = case_of(scene, "null");
  const TemporaryFolder folder;
  write_run(folder.path() / "out", run, result_of(run));
  const nlohmann::ordered_json manifest = manifest_in(folder.path() / "out");
  EXPECT_EQ(manifest["limits"]["volume_error"], 0.05);
  EXPECT_EQ(manifest["limits"]["tunnelled_nodes"], 0);
  EXPECT_GE(manifest["machine_state"]["involuntary_context_switches"].get<long>(), 0);
  EXPECT_GT(manifest["cpu_ns"]["before_first_frame"].get<Nanoseconds>(), 0);
  EXPECT_GT(manifest["cpu_ns"]["after_last_frame"], manifest["cpu_ns"]["before_first_frame"]);
  EXPECT_EQ(manifest["muscle"]["pressure"], 1);
}

TEST(RunOutput, SaysWhichBonesWerePrunedAndWhy) {
  const Scene scene = plain_scene();
  RunCase run = case_of(scene, "bvh");
  const TemporaryFolder folder;
  write_run(folder.path() / "pruned", run, result_of(run));
  const auto pruned = manifest_in(folder.path() / "pruned")["pruned"];
  ASSERT_EQ(pruned.size(), 1U);
  EXPECT_EQ(pruned[0]["bone"], "box");
  EXPECT_EQ(pruned[0]["reason"], "out_of_reach");
  EXPECT_NEAR(pruned[0]["distance_m"].get<double>(), 0.07, 1e-3);
  EXPECT_LT(pruned[0]["margin_m"], pruned[0]["distance_m"]);
  EXPECT_EQ(pruned[0]["saved_triangles"], 12);
  EXPECT_EQ(pruned[0]["saved_queries"], 2 * 42) << "nodes in two frames of a step";
  EXPECT_TRUE(pruned[0]["frame_back"].is_null());
  EXPECT_EQ(pruned[0]["is_back"], false);
  const std::string id = run_id(run);
  run.prune = false;
  EXPECT_NE(run_id(run), id);
  write_run(folder.path() / "whole", run, result_of(run));
  EXPECT_TRUE(manifest_in(folder.path() / "whole")["pruned"].empty());
}

TEST(RunOutput, KeepsWhatTheSceneWasWarnedOf) {
  Scene scene = plain_scene();
  scene.warnings = {{"a_rule", "a text"}, {"another", "of it"}};
  const RunCase run = case_of(scene, "null");
  const TemporaryFolder folder;
  write_run(folder.path() / "out", run, result_of(run));
  const auto warnings = manifest_in(folder.path() / "out")["warnings"];
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_EQ(warnings[0]["rule"], "a_rule");
  EXPECT_EQ(warnings[1]["text"], "of it");
}

TEST(RunOutput, SaysWhatWasAddedAndLeavesTheResolvedScene) {
  Scene scene = plain_scene();
  const TemporaryFolder folder;
  const std::filesystem::path out = folder.path() / "out";
  const auto write = [&] {
    const RunCase run = case_of(scene, "null");
    write_run(out, run, result_of(run));
    return manifest_in(out);
  };
  EXPECT_FALSE(write().contains("added_effects"));
  EXPECT_FALSE(exists(out / "resolved_scene.toml"));
  scene.auto_effects = {
      .wanted = true, .added = {{"friction", "a_rule", "a reason"}}, .resolved_text = "title = \"resolved\"\n"};
  for (int i = 0; i < 2; ++i) {  // its own folder is replaced
    const nlohmann::ordered_json manifest = write();
    ASSERT_EQ(manifest["added_effects"].size(), 1U);
    EXPECT_EQ(manifest["added_effects"][0]["effect"], "friction");
    EXPECT_EQ(manifest["added_effects"][0]["rule"], "a_rule");
    EXPECT_EQ(manifest["added_effects"][0]["reason"], "a reason");
    std::ifstream in(out / "resolved_scene.toml");
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line, "title = \"resolved\"");
  }
}

TEST(RunOutput, LookingForSelfIntersectionsIsAnotherCase) {
  const Scene scene = plain_scene();
  RunCase run = case_of(scene, "null");
  const std::string id = run_id(run);
  run.count_self_intersections = true;
  EXPECT_NE(run_id(run), id);
}

}  // namespace
}  // namespace musclebench
