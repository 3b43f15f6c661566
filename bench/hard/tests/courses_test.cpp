#include "bench/hard/courses.hpp"

#include <string>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/hard/run_figures.hpp"

namespace musclebench {
namespace {

/// What is said of so many runs of a short scene.
HardCell cell_of(int runs) {
  const HardRequest request{.backend = exact_backend()};
  return watched(request, true, [&] {
    const MovedScene run = moved_in_time(request, load_scene(scene_of("hard/step_size")), runs);
    EXPECT_EQ(run.result.state_hash, moved(request, scene_of("hard/step_size")).result.state_hash);
    return HardCell{Verdict::holds, run.said(), {}};
  });
}

TEST(MovedInTime, IsTheSameRunWhereItDoesNotTakeTooLong) { EXPECT_EQ(cell_of(1).verdict, Verdict::holds); }

TEST(MovedInTime, IsLeftOutWithTheTimeThatItWouldTake) {
  const HardCell cell = cell_of(10'000'000);
  EXPECT_EQ(cell.verdict, Verdict::not_applicable);
  EXPECT_EQ(cell.detail.find("would take "), 0) << cell.detail;
  EXPECT_NE(cell.detail.find("of at most 4.8: in the long run only (--all)"), std::string::npos) << cell.detail;
}

/// A figure of a first run, then one that takes too long.
HardCell cell_with(double first) {
  const HardRequest request{.backend = exact_backend()};
  return watched_runs(request, true, [&](RunFigures& figures) {
    figures.add({"of the first run", first, 1});
    moved_in_time(request, load_scene(scene_of("hard/step_size")), 10'000'000);
  });
}

TEST(WatchedRuns, KeepWhatIsBeyondItsBarThoughALaterRunTakesTooLong) {
  EXPECT_EQ(cell_with(1).verdict, Verdict::not_applicable);
  const HardCell red = cell_with(2);
  EXPECT_EQ(red.verdict, Verdict::breaks);
  ASSERT_EQ(red.figures.size(), 1U);
  EXPECT_EQ(red.detail.find("a later run would take "), 0) << red.detail;
}

}  // namespace
}  // namespace musclebench
