#include "bench/hard/courses.hpp"

#include <string>

#include <gtest/gtest.h>

#include "backends/registry.hpp"

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

}  // namespace
}  // namespace musclebench
