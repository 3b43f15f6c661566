#include "core/measure/outcome_limits.hpp"

#include <limits>
#include <set>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

MuscleAtRest muscle() {
  MuscleAtRest rest;
  rest.volumes_m3 = {2};
  rest.mean_edge_length_m = 0.001;
  rest.free_nodes = 1000;
  rest.triangles = 2000;
  return rest;
}

/// As bad as a run may be.
Outcome at_the_limits() {
  Outcome outcome;
  outcome.max_volume_error = 0.05;
  outcome.turned_inside_out = false;
  outcome.tunnelled_nodes = 0;
  outcome.stuck_nodes = 10;
  outcome.max_surface_depth_m = 0.004;
  outcome.max_edge_stretch = 4;
  outcome.nodes_inside_at_rest = 3;
  outcome.depth_at_rest_m = 0.001;
  outcome.self_intersecting_triangles = 107;
  outcome.self_intersecting_triangles_at_rest = 7;
  return outcome;
}

std::string only_suspicion(const Outcome& outcome, const MuscleAtRest& rest = muscle()) {
  const std::vector<std::string> found = suspicions(outcome, rest);
  return found.size() == 1 ? found.front() : std::to_string(found.size()) + " suspicions";
}

TEST(OutcomeLimits, WithinThemNothingIsSuspect) {
  EXPECT_TRUE(suspicions(at_the_limits(), muscle()).empty());
  EXPECT_TRUE(suspicions(Outcome(), MuscleAtRest()).empty()) << "what is not known is not suspect";
}

TEST(OutcomeLimits, BeyondEachOneTheReasonIsTold) {
  Outcome outcome = at_the_limits();
  outcome.max_volume_error = 0.537;
  EXPECT_EQ(only_suspicion(outcome), "the volume is off its target by 53.7 % (limit 5 %)");
  outcome = at_the_limits();
  outcome.turned_inside_out = true;
  EXPECT_EQ(only_suspicion(outcome), "the muscle is turned inside out");
  outcome = at_the_limits();
  outcome.tunnelled_nodes = 642;
  EXPECT_EQ(only_suspicion(outcome), "642 nodes tunnelled through a bone (limit 0)");
  outcome = at_the_limits();
  outcome.stuck_nodes = 125;
  EXPECT_EQ(only_suspicion(outcome), "12.5 % of the free nodes stuck (limit 1 %)");
  outcome = at_the_limits();
  outcome.max_surface_depth_m = 0.005;
  EXPECT_EQ(only_suspicion(outcome), "the surface is 5.000 mm deep, 5 mean edges (limit 4)");
  outcome = at_the_limits();
  outcome.max_edge_stretch = 4.5;
  EXPECT_EQ(only_suspicion(outcome), "an edge is 4.5 times as long as at rest (limit 4)");
  outcome = at_the_limits();
  outcome.depth_at_rest_m = 0.0066;
  EXPECT_EQ(only_suspicion(outcome),
            "3 free nodes were inside bones before the first frame, up to 6.600 mm deep, 6.6 mean edges (limit 1)");
  outcome = at_the_limits();
  outcome.self_intersecting_triangles = 207;
  EXPECT_EQ(only_suspicion(outcome), "10 % of the triangles pass through others (limit 5 %)");
}

TEST(OutcomeLimits, WhatAJudgementLeavesOpenIsNotWithinTheLimit) {
  Outcome outcome = at_the_limits();
  outcome.max_surface_depth_m = 0.001;
  outcome.max_surface_depth_bound_m = 0.02;
  EXPECT_TRUE(suspicions(outcome, muscle()).empty()) << "every judgement was complete";
  outcome.open_judgements = 3;
  EXPECT_EQ(only_suspicion(outcome),
            "the surface may be 20.000 mm deep, 20 mean edges (limit 4): the Referee's budget did not suffice for 3 "
            "frames");
  outcome.max_surface_depth_bound_m = 0.004;
  EXPECT_TRUE(suspicions(outcome, muscle()).empty());
  outcome.max_surface_depth_m = 0.005;
  outcome.max_surface_depth_bound_m = 0.02;
  EXPECT_EQ(only_suspicion(outcome), "the surface is 5.000 mm deep, 5 mean edges (limit 4)");
}

TEST(OutcomeLimits, AFigureThatIsNoNumberIsBeyondItsLimit) {
  Outcome outcome = at_the_limits();
  outcome.max_edge_stretch = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(suspicions(outcome, muscle()).size(), 1U);
}

TEST(OutcomeLimits, EachHasANameAndAMeaning) {
  std::set<std::string_view> names;
  for (const OutcomeLimit& limit : outcome_limits()) {
    EXPECT_TRUE(names.insert(limit.info.name).second);
    EXPECT_FALSE(limit.info.help.empty());
  }
}

}  // namespace
}  // namespace musclebench
