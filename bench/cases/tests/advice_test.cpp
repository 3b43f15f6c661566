#include "bench/cases/advice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {
namespace {

/// A world where errors and costs follow formulas: fields err by (cells / 64)^-2 tenths of a millimetre, and can't be
/// adaptive.
std::optional<Assessment> modelled(const Configuration& configuration, std::string& reason) {
  Assessment assessment;
  assessment.configuration = configuration;
  const auto found = configuration.parameters.find("cells");
  const double cells =
      found == configuration.parameters.end() ? 0.0 : static_cast<double>(std::get<std::int64_t>(found->second));
  if (configuration.backend == "bvh") {
    assessment.collision_ns = {9e6, 8.9e6, 9.1e6};
    assessment.structure_bytes = 40'000'000;
  } else if (configuration.backend == "voxel") {
    assessment.error_m = 0.2 / cells;
    assessment.collision_ns = {2e5, 1.9e5, 2.1e5};
    assessment.structure_bytes = static_cast<std::size_t>(cells * cells * cells / 8);
  } else if (configuration.backend == "sdf") {
    if (cells > 200 || cells == 0) {
      reason = "no memory";
      return std::nullopt;
    }
    assessment.error_m = 1e-4 * std::pow(64 / cells, 2);
    assessment.collision_ns = {3e5, 2.9e5, 3.1e5};
    assessment.structure_bytes = static_cast<std::size_t>(32 * cells * cells * cells);
  } else {
    assessment.error_m = 1e-3;
    assessment.collision_ns = {5e7, 4e7, 6e7};
  }
  return assessment;
}

/// Of backends that every build has and that are quick.
std::vector<AdvisePlan> own_plans() {
  std::vector<AdvisePlan> plans = advise_plans();
  std::erase_if(plans, [](const AdvisePlan& plan) {
    return plan.backend != "voxel" && plan.backend != "sdf" && plan.backend != "bvh" && plan.backend != "brute_force";
  });
  return plans;
}

/// Every trial holds.
const Try holding = [](const Configuration&, double /*seconds*/) { return std::optional(Trial{}); };

std::string chosen(double depth_m, const Try& try_out = holding) {
  const Advice advice = find_advice({depth_m, 1000, advise_plans()}, modelled, try_out);
  return advice.chosen ? advice.measured[*advice.chosen].configuration.text() : "none";
}

TEST(Advice, TheStudiesNameWhatIsTriedAndInWhichOrder) {
  std::vector<AdvisePlan> plans = advise_plans();
  std::erase_if(plans, [](const AdvisePlan& plan) {
    return plan.backend != "voxel" && plan.backend != "bvh" && plan.backend != "sdf" && plan.backend != "fcl";
  });
  const Advice advice = find_advice({7e-5, 1000, plans}, modelled, holding);
  std::vector<std::string> tried;
  for (const Assessment& measured : advice.measured) {
    tried.push_back(measured.configuration.text());
  }
  std::vector<std::string> expected{
      "voxel cells=64", "bvh",          "voxel cells=16", "voxel cells=32", "voxel cells=128", "voxel cells=256",
      "sdf cells=8",    "sdf cells=16", "sdf cells=32",   "sdf cells=64",   "sdf cells=128",   "sdf cells=85"};
  if (std::any_of(backend_registry().begin(), backend_registry().end(),
                  [](const BackendEntry& entry) { return entry.name == "fcl"; })) {
    expected.insert(expected.end(), {"fcl", "fcl bounding_volume=OBB"});
  }
  EXPECT_EQ(tried, expected);
  EXPECT_EQ(advice.unit_of_price->text(), "voxel cells=64");
}

TEST(Advice, TheCheapestThatHolds) {
  EXPECT_EQ(chosen(5e-3), "voxel cells=64");
  EXPECT_EQ(chosen(1e-6), "bvh");
}

TEST(Advice, AResolutionBetweenTwoIsPredictedFromTheObservedOrder) {
  // (cells / 64)^-2 * 0.1 mm = 0.07 mm at 76.5 cells; a tenth finer is 85.
  EXPECT_EQ(chosen(7e-5), "sdf cells=85");
  // 128 cells are needed almost exactly: nothing in between is worth a build.
  EXPECT_EQ(chosen(2.6e-5), "sdf cells=128");
}

/// The same, but adaptive fields err a quarter more than they were asked for, and take a second for a tenth of a
/// millimetre, 40 times as long for a hundredth.
std::optional<Assessment> modelled_adaptive(const Configuration& configuration, std::string& reason) {
  const auto found = configuration.parameters.find("max_error_mm");
  if (found == configuration.parameters.end()) {
    return modelled(configuration, reason);
  }
  const double wanted_mm = std::get<double>(found->second);
  Assessment assessment;
  assessment.configuration = configuration;
  assessment.error_m = 1.25e-3 * wanted_mm;
  assessment.collision_ns = {3e5, 2.9e5, 3.1e5};
  assessment.structure_bytes = static_cast<std::size_t>(1e5 / wanted_mm);
  assessment.build_ns = static_cast<Nanoseconds>(1e9 * std::pow(0.1 / wanted_mm, 1.6));
  return assessment;
}

TEST(Advice, AnAdaptiveFieldIsMadeFinerUntilItsContactsHold) {
  const Advice advice = find_advice({1e-4, 1000, advise_plans()}, modelled_adaptive, holding);
  std::vector<std::string> adaptive;
  for (const Assessment& measured : advice.measured) {
    if (measured.configuration.parameters.contains("max_error_mm")) {
      adaptive.push_back(measured.configuration.text());
    }
  }
  const std::vector<std::string> expected{"sdf max_error_mm=0.4", "sdf max_error_mm=0.1", "sdf max_error_mm=0.0727"};
  EXPECT_EQ(adaptive, expected);
  EXPECT_EQ(advice.measured[advice.chosen.value()].configuration.text(), expected.back());
}

TEST(Advice, AnAdaptiveFieldThatWouldTakeTooLongIsLeftOut) {
  const Advice advice = find_advice({1e-7, 2000, advise_plans()}, modelled_adaptive, holding);
  ASSERT_FALSE(advice.omitted.empty());
  EXPECT_EQ(advice.omitted.back().configuration.text(), "sdf max_error_mm=0.0004");
  EXPECT_EQ(advice.measured[advice.chosen.value()].configuration.text(), "bvh");
}

TEST(Advice, NoDepthAtAllIsHeldByWhatIsExact) {
  const Advice advice = find_advice({0, 1000, advise_plans()}, modelled_adaptive, holding);
  EXPECT_EQ(advice.measured[advice.chosen.value()].configuration.text(), "bvh");
}

TEST(Advice, OfEquallyFastOnesTheSmallest) {
  const auto same_speed = [](const Configuration& configuration, std::string& reason) {
    std::optional<Assessment> assessment = modelled(configuration, reason);
    if (assessment) {
      assessment->collision_ns = {1e6, 0.9e6, 1.1e6};
      assessment->error_m = 0;
    }
    return assessment;
  };
  const Advice advice = find_advice({1e-4, 1000, own_plans()}, same_speed, holding);
  EXPECT_EQ(advice.measured[advice.chosen.value()].configuration.text(), "voxel cells=16");
}

/// Two sizes of a structure that both hold; the larger one is the faster by `ratio`.
Advice two_sizes(double ratio) {
  AdvisePlan plan{"grid"};
  plan.points = {{{"cells", std::int64_t{2}}}, {{"cells", std::int64_t{1}}}};
  return find_advice(
      {1e-4, 1000, {plan}},
      [&](const Configuration& configuration, std::string& /*reason*/) {
        const bool large = configuration.text() == "grid cells=2";
        Assessment assessment;
        assessment.configuration = configuration;
        const double time_ns = large ? 1e6 : ratio * 1e6;
        assessment.collision_ns = {time_ns, 0.999 * time_ns, 1.001 * time_ns};
        assessment.structure_bytes = large ? 52'900'000 : 7'300'000;
        return std::optional(assessment);
      },
      holding);
}

TEST(Advice, ASmallerOneThatIsSlowerByNoMoreThanADriftIsTakenAndItSaysWhy) {
  const Advice advice = two_sizes(1.05);
  EXPECT_EQ(advice.measured[advice.chosen.value()].configuration.text(), "grid cells=1");
  EXPECT_EQ(advice.measured[advice.fastest.value()].configuration.text(), "grid cells=2");
  const std::vector<std::string> lines = explain(advice, {1e-4}, {46, 314});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_NE(lines[0].find("smaller than grid cells=2 (7.3 against 52.9 MB)"), std::string::npos) << lines[0];
  EXPECT_NE(lines[0].find("1.05 times its time"), std::string::npos) << lines[0];
}

TEST(Advice, ASmallerOneThatIsSlowerIsNot) {
  const Advice advice = two_sizes(1.2);
  EXPECT_EQ(advice.chosen, advice.fastest);
  EXPECT_NE(explain(advice, {1e-4}, {46, 314}).at(0).find("the fastest"), std::string::npos);
}

TEST(Advice, ANarrowRefusalByFewFramesIsSaid) {
  const Advice advice = find_advice({0.9e-4, 1000, advise_plans()}, modelled, holding);
  const auto says = [&](const AskedFrames& frames) {
    const std::vector<std::string> lines = explain(advice, {0.9e-4}, frames);
    return std::any_of(lines.begin(), lines.end(), [](const std::string& line) {
      return line.starts_with("sdf cells=64") && line.find("by 46 of 314 frames") != std::string::npos;
    });
  };
  EXPECT_TRUE(says({46, 314})) << "sdf cells=64 errs by 0.1 mm";
  EXPECT_FALSE(says({314, 314}));
}

TEST(AdvisePlan, AStudyThatNamesWhatTheBackendHasNotIsRefusedWithItsPlace) {
  const auto message = [](const std::string& study) -> std::string {
    BackendEntry entry = find_backend("voxel");
    entry.study = study;
    try {
      (void)read_advise_plan(entry);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message("label = \"voxel\""), "");
  EXPECT_NE(message("[advise]\npoints = [{cels = 3}]").find("voxel/study.toml:2: points[1]: cels: is unknown"),
            std::string::npos)
      << message("[advise]\npoints = [{cels = 3}]");
  EXPECT_NE(message("[advise]\nrefine = { parameter = 'size' }").find("'size' is no number"), std::string::npos);
  EXPECT_NE(message("[advise]\nrefine = { parameter = 'cells', from = 64, to = 8, factor = 2 }").find("does not lead"),
            std::string::npos);
  EXPECT_NE(message("[advise]\nwanted_error = { parameter = 'cells', factor = 2, coarsest = 1, build_order = 1 }")
                .find("no length"),
            std::string::npos);
}

TEST(Advice, WhatNoneReachesNamesTheBest) {
  const auto inexact = [](const Configuration& configuration, std::string& reason) {
    std::optional<Assessment> assessment = modelled(configuration, reason);
    if (assessment) {
      assessment->error_m += 1e-5;
    }
    return assessment;
  };
  const Advice advice = find_advice({1e-9, 1000, advise_plans()}, inexact, holding);
  EXPECT_FALSE(advice.chosen);
  EXPECT_EQ(advice.measured[advice.best.value()].configuration.text(), "bvh");
  ASSERT_FALSE(advice.omitted.empty());
  EXPECT_EQ(advice.omitted.front().configuration.text(), "sdf cells=256");
  EXPECT_EQ(advice.omitted.front().reason, "no memory");
}

TEST(Advice, WithoutTimeNothingIsMeasured) {
  const Advice advice = find_advice({1e-4, 0, advise_plans()}, modelled, holding);
  EXPECT_TRUE(advice.measured.empty());
  EXPECT_FALSE(advice.chosen);
  EXPECT_FALSE(advice.best);
  EXPECT_FALSE(advice.omitted.empty());
}

/// A world in which a field leaves nodes deeper than its surface promises.
Try leaving(double factor) {
  return [factor](const Configuration& configuration, double /*seconds*/) {
    std::string reason;
    Trial trial;
    trial.node_depth_m = factor * modelled(configuration, reason)->error_m;
    return std::optional(trial);
  };
}

std::string refusal_of(const Advice& advice, const std::string& configuration) {
  for (const Assessment& row : advice.measured) {
    if (row.configuration.text() == configuration) return row.refusal;
  }
  return "not measured";
}

TEST(Advice, WhatItRecommendsItHasRunAndFoundToHold) {
  const Advice advice = find_advice({1e-4, 1000, own_plans()}, modelled, leaving(0.5));
  ASSERT_TRUE(advice.chosen);
  const Assessment& chosen = advice.measured[*advice.chosen];
  ASSERT_TRUE(chosen.trial);
  EXPECT_LE(chosen.trial->node_depth_m, 1e-4);
}

TEST(Advice, WhatDoesNotHoldInItsOwnRunIsMadeFinerOrLeft) {
  // 64 cells promise 0.1 mm and leave 0.15; 128 cells leave 0.0375.
  const Advice advice = find_advice({1.0001e-4, 1000, own_plans()}, modelled, leaving(1.5));
  EXPECT_EQ(advice.measured[advice.chosen.value()].configuration.text(), "sdf cells=128");
  EXPECT_NE(refusal_of(advice, "sdf cells=64").find("leaves nodes 0.15 mm deep"), std::string::npos);
  // Nothing but what is exact holds what it promises.
  const Advice exact = find_advice({1e-4, 1000, own_plans()}, modelled, leaving(1e6));
  EXPECT_EQ(exact.measured[exact.chosen.value()].configuration.text(), "bvh");
}

TEST(Advice, ARunThatIsWorseThanTheExactOneIsRefused) {
  const auto suspect = [](bool exact_too) {
    return [exact_too](const Configuration& configuration, double /*seconds*/) {
      Trial trial;
      if (configuration.backend != "bvh" || exact_too) trial = {.status = "suspect", .status_detail = "folded"};
      return std::optional(trial);
    };
  };
  EXPECT_EQ(chosen(5e-3, suspect(false)), "bvh");
  EXPECT_EQ(chosen(5e-3, suspect(true)), "voxel cells=64");
  const auto tunnelling = [](const Configuration& configuration, double /*seconds*/) {
    return std::optional(Trial{.tunnelled_nodes = configuration.backend == "voxel" ? 3 : 0});
  };
  EXPECT_NE(chosen(5e-3, tunnelling).find("sdf"), std::string::npos);
  const auto diverging = [](const Configuration& configuration, double /*seconds*/) {
    return std::optional(Trial{.status = configuration.backend == "bvh" ? "ok" : "diverged"});
  };
  EXPECT_EQ(chosen(5e-3, diverging), "bvh");
}

TEST(Advice, WithoutTimeForItsRunNothingIsRecommended) {
  const Advice advice = find_advice({1e-4, 1000, advise_plans()}, modelled,
                                    [](const Configuration&, double /*seconds*/) { return std::optional<Trial>(); });
  EXPECT_FALSE(advice.chosen);
  ASSERT_TRUE(advice.untried);
  EXPECT_LE(advice.measured[*advice.untried].error_m, 1e-4);
}

}  // namespace
}  // namespace musclebench
