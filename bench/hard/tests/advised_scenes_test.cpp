#include <algorithm>
#include <functional>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bench/cases/advise_case.hpp"
#include "bench/hard/fuzz_scene.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {
namespace {

constexpr double wanted_m = 1e-4;
constexpr int frames = 8;
/// CPU time for one scene.
constexpr double budget_s = 30;

/// What is quick and can be asked about single points.
std::vector<AdvisePlan> quick_plans() {
  std::vector<AdvisePlan> plans = advise_plans();
  std::erase_if(plans, [](const AdvisePlan& plan) { return plan.backend == "fcl"; });
  for (AdvisePlan& plan : plans) {
    plan.wanted_error.reset();
    if (plan.refine) plan.refine->from = 16, plan.refine->to = std::min(plan.refine->to, 64.0);
  }
  return plans;
}

Advice advise(const Scene& scene) {
  const AdviceInput input = run_exactly(scene, budget_s, [](int /*frames*/) {});
  const auto measure = [&](const Configuration& configuration, std::string& reason) -> std::optional<Assessment> {
    try {
      return assess(scene, configuration, {}, *input.frames, reason, [](int, int) {});
    } catch (const InputError& refused) {
      reason = refused.what();
      return std::nullopt;
    }
  };
  const auto run = [&](const Configuration& configuration, double left_s) {
    return try_out(scene, configuration, 1, left_s, {});
  };
  return find_advice({wanted_m, budget_s, quick_plans()}, measure, run);
}

/// The largest depth of a free node in any frame of a run of its own.
double depth_in_its_run_m(const Scene& scene, const Configuration& configuration) {
  const RunResult run = run_configuration(scene, configuration, 2, true, [] { return false; }, {});
  double largest_m = 0;
  for (const StepRecord& record : run.records) largest_m = std::max(largest_m, record.depth.max_depth_m);
  return largest_m;
}

/// So many recommendations, in scenes from that seed on. Of most random scenes none is made: they move so fast that
/// even exact answers leave nodes millimetres deep, and then every trial has to say so.
void expect_that_advice_holds(int recommendations, std::uint64_t first_seed) {
  int recommended = 0;
  for (std::uint64_t seed = first_seed; recommended < recommendations && seed < 1000; ++seed) {
    FuzzScene random = fuzz_scene(seed, {"bvh"});
    random.loop["frames"] = std::int64_t{frames};
    SCOPED_TRACE(fmt::format("seed {}", seed));
    try {
      const Scene scene = read_fuzz_scene(random);
      const Advice advice = advise(scene);
      if (advice.chosen) {
        ++recommended;
        EXPECT_LE(depth_in_its_run_m(scene, advice.measured[*advice.chosen].configuration), wanted_m);
        continue;
      }
      if (advice.untried) continue;  // the time was up before the next trial
      for (const Assessment& row : advice.measured) {
        EXPECT_TRUE(row.error_m > wanted_m || !row.refusal.empty()) << row.configuration.text();
      }
    } catch (const InputError&) {
      // Not a scene, or one that diverges.
    }
  }
  EXPECT_EQ(recommended, recommendations);
}

/// Seed 4 uses up its CPU time, and nothing is recommended before 22: of the seeds between every trial says why.
TEST(AdvisedScenes, WhatIsRecommendedHoldsOverTheWholeMotion) { expect_that_advice_holds(1, 5); }

/// Takes minutes; asked for by .ci/weekly.
TEST(AdvisedScenes, DISABLED_WhatIsRecommendedHoldsInTwentyRandomScenes) { expect_that_advice_holds(20, 0); }

}  // namespace
}  // namespace musclebench
