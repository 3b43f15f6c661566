#include "bench/hard/hard_case.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <functional>
#include <memory>
#include <set>
#include <stdexcept>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/cases/scene_source.hpp"
#include "bench/hard/cell_process.hpp"
#include "bench/hard/hard_matrix.hpp"
#include "bench/hard/sane_figures.hpp"
#include "bench/hard/tests/broken_backend.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {
namespace {

HardRequest exact() { return {.backend = exact_backend()}; }

const HardCase& case_of(const std::vector<HardCase>& all, std::string_view id) {
  return *std::ranges::find(all, id, &HardCase::id);
}

TEST(HardCase, EachIsToldInWordsOnceAndItsSceneIsThere) {
  std::set<std::string_view> ids;
  for (const HardCase& each : hard_cases()) {
    EXPECT_TRUE(ids.insert(each.id).second) << each.id;
    EXPECT_TRUE(each.what.ends_with('.') && each.why.ends_with('.')) << each.id;
    EXPECT_FALSE(each.bar.empty() || each.bar.ends_with('.')) << each.id;
    if (each.scene.empty()) continue;
    SceneChoice choice;
    choice.scene = each.scene;
    EXPECT_NO_THROW((void)load_scene(choice)) << each.id;
  }
}

TEST(HardCase, AFigureBeyondItsBarBreaksUnlessItWasSaidAndMayBe) {
  const HardRequest of_exact = exact();
  const HardRequest of_voxel{.backend = find_backend("voxel")};
  EXPECT_EQ(judged({{"f", 1, 1}}, of_exact).verdict, Verdict::holds);
  EXPECT_EQ(judged({{"f", 1, 1}, {"g", 1.001, 1}}, of_exact).verdict, Verdict::breaks);
  EXPECT_EQ(judged({{"f", std::nan(""), 1}}, of_exact).verdict, Verdict::breaks);
  EXPECT_EQ(judged({{"f", 2, 1}}, of_exact, "suspect").verdict, Verdict::breaks);
  EXPECT_EQ(judged({{"f", 2, 1}}, of_voxel, "suspect").verdict, Verdict::refused);
  EXPECT_EQ(judged({{"f", 2, 1}}, of_voxel, "").verdict, Verdict::breaks);
  EXPECT_EQ(judged({{"f", 2, 1}}, of_voxel, "suspect", MayRefuse::nobody).verdict, Verdict::breaks);
  EXPECT_EQ(judged({{"f", 2, 1}}, of_exact, "suspect", MayRefuse::everybody).verdict, Verdict::refused);
  EXPECT_EQ(judged({{"f", 1, 1}}, of_exact, "suspect", MayRefuse::everybody).verdict, Verdict::holds);
}

TEST(HardCase, TheWorstFigureIsTheOneFarthestBeyondItsBar) {
  const HardCell cell{Verdict::breaks, "", {{"a", 0.5, 1}, {"b", 30, 10}, {"c", 2, 1}}};
  EXPECT_EQ(worst_figure(cell)->name, "b");
  EXPECT_EQ(worst_figure({Verdict::breaks, "", {{"a", 5, 1}, {"b", std::nan(""), 1}}})->name, "b");
  EXPECT_EQ(worst_figure({Verdict::breaks, "", {{"a", 0.5, 1}, {"b", 1, 0}}})->name, "b");
  EXPECT_EQ(worst_figure({Verdict::breaks, "", {{"a", 1, 0}, {"b", 30, 0}}})->name, "b");
  EXPECT_EQ(worst_figure({}), nullptr);
}

/// A block that lies half in its plate, and then as far in it with its other half.
TEST(SaneFigures, TrianglesThatPassAtRestExcuseNoOthers) {
  MovedScene run{load_scene(scene_of("hard/resting_contact")), {}};
  const Eigen::AlignedBox3d plate = bounding_box(run.scene.bone_meshes.front().mesh.vertices);
  const Vec3 middle = bounding_box(run.scene.muscle_mesh.vertices).center();
  const Vec3 top(plate.center().x(), plate.center().y(), plate.max().z());
  Snapshot half_in;
  Snapshot turned;
  half_in.bone_poses = turned.bone_poses = std::vector<RigidMotion>(run.scene.bones.size());
  for (const Vec3& node : run.scene.muscle_mesh.vertices) {
    const Vec3 off = node - middle + Vec3(0, 0, 1e-4);
    half_in.positions.emplace_back(top + off);
    turned.positions.emplace_back(top + Vec3(off.x(), -off.y(), -off.z()));
  }
  run.result.snapshots = {half_in, half_in};
  run.result.records.resize(1);
  EXPECT_EQ(passing_triangles(run, 0).bones, 0);
  run.result.snapshots.push_back(turned);
  run.result.records.resize(2);
  EXPECT_GT(passing_triangles(run, 0).bones, 10);
}

TEST(HardCell, IsPackedIntoALineAndBack) {
  const HardCell cell{Verdict::refused, "with \"quotes\"\nand lines", {{"a", 1.0 / 3, 1e-12, "mm"}, {"b", 1e308, 0}}};
  const HardCell read = unpacked(packed(cell));
  EXPECT_EQ(read.verdict, cell.verdict);
  EXPECT_EQ(read.detail, cell.detail);
  ASSERT_EQ(read.figures.size(), 2U);
  EXPECT_EQ(read.figures[0].value, 1.0 / 3);
  EXPECT_EQ(read.figures[0].bar, 1e-12);
  EXPECT_EQ(read.figures[0].unit, "mm");
  const HardCell nan = unpacked(packed({Verdict::breaks, "", {{"a", std::nan(""), 1}, {"b", -INFINITY, INFINITY}}}));
  EXPECT_TRUE(std::isnan(nan.figures[0].value));
  EXPECT_EQ(nan.figures[1].value, -INFINITY);
  EXPECT_EQ(nan.figures[1].bar, INFINITY);
  EXPECT_THROW((void)unpacked("{}"), std::exception);
}

HardCell in_process(const std::function<HardCell()>& work) { return run_in_process(work, 60); }

TEST(HardCell, HasAProcessOfItsOwn) {
  const HardCell fine = in_process([]() -> HardCell {
    return {Verdict::holds, std::string(200'000, 'x'), {}};  // more than a pipe holds
  });
  EXPECT_EQ(fine.verdict, Verdict::holds);
  EXPECT_EQ(fine.detail.size(), 200'000U);
  const HardCell refused = in_process([]() -> HardCell { throw InputError("scene.toml", "is odd"); });
  EXPECT_EQ(refused.verdict, Verdict::refused);
  EXPECT_EQ(refused.detail, "scene.toml: is odd");
  const HardCell failed = in_process([]() -> HardCell { throw std::logic_error("oh"); });
  EXPECT_EQ(failed.verdict, Verdict::breaks);
  EXPECT_EQ(failed.detail, "unexpected failure: oh");
}

TEST(HardCell, BreaksWhereItsProcessCrashesOrHangs) {
  const HardCell killed = in_process([]() -> HardCell {
    (void)std::raise(SIGKILL);
    return {};
  });
  EXPECT_EQ(killed.verdict, Verdict::breaks);
  EXPECT_NE(killed.detail.find("Killed"), std::string::npos) << killed.detail;
  const HardCell hung = run_in_process(
      []() -> HardCell {
        std::this_thread::sleep_for(std::chrono::hours(1));
        return {};
      },
      0.2);
  EXPECT_EQ(hung.verdict, Verdict::breaks);
  EXPECT_EQ(hung.detail, "still at work after 0.2 s");
}

TEST(HardCell, BreaksWhereItsProcessEndsWithAnotherExitCode) {
  const HardCell ended = in_process([]() -> HardCell { _exit(3); });
  EXPECT_EQ(ended.verdict, Verdict::breaks);
  EXPECT_EQ(ended.detail, "exit code 3");
}

TEST(HardCell, TheFirstToEndIsTakenFirst) {
  const auto after = [](std::chrono::milliseconds time, const char* words) {
    return [=]() -> HardCell {
      std::this_thread::sleep_for(time);
      return {Verdict::holds, words};
    };
  };
  std::deque<CellProcess> at_work;
  at_work.emplace_back(after(std::chrono::hours(1), "never"), 60.0);
  at_work.emplace_back(after(std::chrono::milliseconds(1), "soon"), 60.0);
  EXPECT_EQ(CellProcess::wait_for_any(at_work), 1U);
  EXPECT_EQ(at_work[1].result().detail, "soon");
  at_work.pop_back();
  at_work.emplace_back(after(std::chrono::hours(1), "late"), 0.1);
  EXPECT_EQ(CellProcess::wait_for_any(at_work), 1U);
  EXPECT_EQ(at_work[1].result().detail, "still at work after 0.1 s");
}

/// One contact too many in one question after the other, and none at all.
TEST(HardCase, EachFigureOfEmptyInputCanBreak) {
  const std::vector<HardCase> all = hard_cases();
  std::set<std::string> broken_figures;
  const auto run = [&](const std::function<SpoilContacts()>& make_spoil) {
    const BackendEntry entry = broken(exact_backend(), "spoilt", make_spoil);
    const HardCell cell = case_of(all, "empty-input").run({.backend = entry});
    for (const HardFigure& figure : cell.figures) {
      if (!figure.holds()) broken_figures.insert(figure.name);
    }
    return cell;
  };
  int questions = 0;  // each is asked of a backend of its own
  const HardCell faithful = run([&questions] {
    ++questions;
    return [](std::vector<Contact>&, int) {};
  });
  EXPECT_EQ(faithful.verdict, Verdict::holds);
  for (int wrong = 0; wrong < questions; ++wrong) {
    int asked = 0;
    run([&asked, wrong]() -> SpoilContacts {
      if (asked++ != wrong) return [](std::vector<Contact>&, int) {};
      return [](std::vector<Contact>& contacts, int) {
        if (contacts.empty()) {
          contacts.emplace_back();
        } else {
          contacts.clear();
        }
      };
    });
  }
  EXPECT_EQ(broken_figures.size(), faithful.figures.size());
}

TEST(HardMatrix, ShowsWhatBreaksWithFigureAndBar) {
  const std::vector<HardCase> all = hard_cases();
  HardMatrix matrix{{"one", "other"}, {all[0], all[1]}};
  matrix.cells = {
      {{Verdict::holds, "", {{"f", 1e-13, 1e-12}}}, {Verdict::not_applicable, "finds no contacts", {}}},
      {{Verdict::breaks, "", {{"missed", 3, 0, "points"}}}, {Verdict::refused, "a | b \"c\"", {{"g", 2, 1}}, 2}}};
  const std::string text = text_of(matrix);
  EXPECT_NE(text.find("BREAKS"), std::string::npos);
  EXPECT_NE(text.find("soundness, one: missed: 3 points (bar 0 points)"), std::string::npos) << text;
  EXPECT_NE(text.find("1 hold, 1 break, 1 refused, 1 not applicable"), std::string::npos) << text;
  const std::string csv = csv_of(matrix);
  EXPECT_NE(csv.find("soundness,other,refused,\"g\",2,1,,\"a | b \"\"c\"\"\",2.000,\n"), std::string::npos) << csv;
  EXPECT_NE(csv.find("oracle-brute-force,other,not applicable,,,,,\"finds no contacts\",0.000,\n"), std::string::npos);
  const std::string page = markdown_of(matrix);
  EXPECT_NE(page.find("**breaks**: 3 points (0 points)"), std::string::npos) << page;
  EXPECT_EQ(page.find("a | b"), std::string::npos);
}

}  // namespace
}  // namespace musclebench
