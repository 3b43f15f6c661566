#include "core/measure/outcome_limits.hpp"

#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "core/measure/outcome.hpp"

namespace musclebench {
namespace {

/// Of 2000 triangles, 200 mm long: 1 mm deep is at the limit.
MuscleAtRest muscle() {
  MuscleAtRest rest;
  rest.volumes_m3 = {2};
  rest.mean_edge_length_m = 0.02;
  rest.free_nodes = 1000;
  rest.triangles = 2000;
  rest.muscles = {{"iliacus", 0.02, 0.2, 2000}, {"psoas", 0.02, 0.2, 2000}};
  rest.bones = {{"pelvis", 0.02}, {"needle", 0.001}, {"sheet", 0}};
  rest.crossing_pairs = {{0, CrossedSurface::bone, 0},
                         {0, CrossedSurface::bone, 2},
                         {0, CrossedSurface::muscle, 1},
                         {0, CrossedSurface::itself, 0}};
  rest.crossings = {0, 7, 7, 7};
  rest.backend = "fcl";
  return rest;
}

WorstDepth depth_of(double depth_m, int bone = 0, const MuscleAtRest& rest = muscle()) {
  const DepthLimit limit = depth_limit(rest.muscles[0], rest.bones[static_cast<std::size_t>(bone)]);
  return {depth_m, limit, {0, bone}, {40, 62.4}, false, 0};
}

/// As bad as a run may be.
Outcome at_the_limits() {
  Outcome outcome;
  outcome.max_volume_error = 0.05;
  outcome.turned_inside_out = false;
  outcome.tunnelled_nodes = 0;
  outcome.stuck_nodes = 10;
  outcome.worst_depth = depth_of(0.001);
  outcome.max_edge_stretch = 9;
  outcome.p99_edge_stretch = 3;
  outcome.crossings = {{2000, 1, 0}, {27, 1, 0}, {27, 1, 0}, {27, 1, 0}};
  outcome.beyond_rest = {{2000, 1, 0}, {20, 1, 0}, {20, 1, 0}, {20, 1, 0}};
  outcome.true_contacts = 1000;
  outcome.missed_beyond = 10;
  return outcome;
}

std::string only_suspicion(const Outcome& outcome, const MuscleAtRest& rest = muscle()) {
  const std::vector<std::string> found = suspicions(outcome, rest);
  std::string all = std::to_string(found.size()) + " suspicions";
  for (const std::string& each : found) all += "; " + each;
  return found.size() == 1 ? found.front() : all;
}

TEST(OutcomeLimits, NoPassageLetsNoTrianglePass) {
  MuscleAtRest rest = muscle();
  Outcome outcome = at_the_limits();
  outcome.crossings = {{1, 12, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  EXPECT_TRUE(suspicions(outcome, rest).empty());
  rest.effects = {"no_passage"};
  EXPECT_EQ(only_suspicion(outcome, rest),
            "1 triangles of iliacus pass through the pelvis in frame 12, and no_passage only keeps apart what is apart "
            "before the first frame and not brought together by bones alone: take settle_substeps or place the meshes "
            "apart");
}

TEST(OutcomeLimits, WithinThemNothingIsSuspect) {
  EXPECT_TRUE(suspicions(at_the_limits(), muscle()).empty()) << only_suspicion(at_the_limits());
  EXPECT_TRUE(suspicions(Outcome(), MuscleAtRest()).empty()) << "what is not known is not suspect";
}

TEST(OutcomeLimits, BeyondEachOneASentenceSaysWhatWhereWhenAndWhatMendsIt) {
  Outcome outcome = at_the_limits();
  outcome.max_volume_error = 0.537;
  outcome.when_volume = {7, 0};
  outcome.volume_muscle = 1;
  EXPECT_EQ(only_suspicion(outcome),
            "the volume of psoas is off its target by 53.7 % in frame 7 (limit 5 %): add volume");
  outcome = at_the_limits();
  outcome.turned_inside_out = true;
  EXPECT_EQ(only_suspicion(outcome), "the muscle is turned inside out: take more substeps");
  outcome = at_the_limits();
  outcome.tunnelled_nodes = 642;
  outcome.when_tunnelled = {9, 30};
  EXPECT_EQ(only_suspicion(outcome),
            "642 nodes went through a bone and are on its wrong side at 30 degrees (frame 9): add tunnelling_guard");
  outcome = at_the_limits();
  outcome.stuck_nodes = 125;
  EXPECT_EQ(only_suspicion(outcome),
            "12.5 % of the free nodes are held by contacts that are none in frame 0 (limit 1 %): take a finer or an "
            "exact backend");
  outcome = at_the_limits();
  outcome.p99_edge_stretch = 3.5;
  EXPECT_EQ(only_suspicion(outcome),
            "one edge of a hundred is 3.5 times as long as at rest, or longer, in frame 0 (limit 3): add edge_length");
}

TEST(OutcomeLimits, ADepthSaysInWhichBoneAndWhy) {
  Outcome outcome = at_the_limits();
  outcome.worst_depth = depth_of(0.0016);
  EXPECT_EQ(only_suspicion(outcome),
            "the surface of iliacus is 1.6 mm deep in the pelvis at 62 degrees (frame 40) (limit 1 mm, 0.5 % of the "
            "muscle's size), because contact acts at nodes: add surface_contact");
  MuscleAtRest rest = muscle();
  rest.effects = {"surface_contact"};
  EXPECT_TRUE(only_suspicion(outcome, rest).ends_with("size): take more substeps"));
  outcome.worst_depth->node_depth_m = 0.0015;
  EXPECT_TRUE(only_suspicion(outcome).ends_with("size): take more substeps"));
  outcome.worst_depth = depth_of(0.0005, 1);
  outcome.worst_depth->is_bone_vertex = true;
  EXPECT_EQ(only_suspicion(outcome),
            "a vertex of the needle is 0.5 mm deep in iliacus at 62 degrees (frame 40) (limit 0.25 mm, 25 % of the "
            "bone's thickness), because contact acts at nodes: add surface_contact");
  outcome = at_the_limits();
  outcome.worst_muscle_depth = {0.002, depth_limit(rest.muscles[0], rest.muscles[1]), {1, 0}, {3, 0}, false, 0.002};
  EXPECT_EQ(only_suspicion(outcome),
            "psoas is 2 mm deep in iliacus in frame 3 (limit 1 mm, 0.5 % of the muscle's size): take more substeps");
}

/// Whatever the mesh: the limits of a coarse one are those of the muscle's and the bone's size.
TEST(OutcomeLimits, ACoarseMeshMayBeNoDeeper) {
  MuscleAtRest rest = muscle();
  rest.muscles[0].mean_edge_length_m = 0.2;
  Outcome outcome = at_the_limits();
  outcome.worst_depth = depth_of(0.0148, 0, rest);
  EXPECT_NE(only_suspicion(outcome, rest).find("14.8 mm deep"), std::string::npos);
}

TEST(OutcomeLimits, CrossingsBeyondThoseAtRestAreSuspectWhereNoDepthIsJudged) {
  Outcome outcome = at_the_limits();
  outcome.beyond_rest[3] = {200, 12, 0};
  EXPECT_EQ(
      only_suspicion(outcome),
      "10 % of the triangles of iliacus pass through the muscle itself in frame 12 (limit 1 %): add self_contact");
  outcome = at_the_limits();
  outcome.beyond_rest[2] = {200, 12, 0};
  EXPECT_EQ(
      only_suspicion(outcome),
      "10 % of the triangles of iliacus pass through psoas in frame 12 (limit 1 %), as no contact between them is "
      "asked for: add muscle_contact");
  MuscleAtRest rest = muscle();
  rest.touching = {{0, 1}};
  EXPECT_TRUE(suspicions(outcome, rest).empty()) << "their depth is judged";
  outcome = at_the_limits();
  outcome.beyond_rest[1] = {200, 12, 0};
  EXPECT_EQ(
      only_suspicion(outcome),
      "10 % of the triangles of iliacus pass through the sheet, which encloses no volume in frame 12 (limit 1 %): "
      "close its surface");
}

TEST(OutcomeLimits, ATendonOutOfItsRingIsSuspectAndItsCureIsTheRightOne) {
  MuscleAtRest rest = muscle();
  rest.rings = {"strap"};
  Outcome outcome = at_the_limits();
  outcome.ring_escape = {.ring = 0, .outside_m = 0.002, .share = 0.26};
  outcome.when_out_of_ring = {7, 0};
  EXPECT_NE(only_suspicion(outcome, rest).find("the tendon in strap is 2 mm out of it in frame 7"), std::string::npos);
  EXPECT_TRUE(only_suspicion(outcome, rest).ends_with("add retinaculum"));
  rest.effects.emplace_back("retinaculum");
  EXPECT_TRUE(only_suspicion(outcome, rest).ends_with("take more substeps"));
  outcome.ring_escape.has_left = true;
  EXPECT_TRUE(only_suspicion(outcome, rest).ends_with("give a larger one"));
  outcome.ring_escape.share = 0.25;
  EXPECT_TRUE(suspicions(outcome, rest).empty());
}

TEST(OutcomeLimits, WhatIsWrongAtRestIsToldApart) {
  MuscleAtRest rest = muscle();
  rest.depth = DepthStatistics{3, 0.001, 0, 0};
  rest.depth_bodies = {0, 0};
  rest.in_muscles = DepthStatistics{3, 0.001, 0, 0};
  rest.in_muscles_bodies = {1, 0};
  rest.shared_faces = {{0, 1, 20}};
  EXPECT_TRUE(suspicions(at_the_limits(), rest).empty());
  rest.depth->max_depth_m = 0.0066;
  EXPECT_EQ(
      only_suspicion(at_the_limits(), rest),
      "3 free nodes were inside bones before the first frame, up to 6.6 mm deep in the pelvis (limit 1 mm, 0.5 % of "
      "the muscle's size): move the two apart, or set settle_substeps");
  rest.depth->max_depth_m = 0;
  rest.in_muscles->max_depth_m = 0.0066;
  EXPECT_EQ(
      only_suspicion(at_the_limits(), rest),
      "psoas was 6.6 mm deep in iliacus before the first frame (limit 1 mm, 0.5 % of the muscle's size): move the "
      "two apart, or set settle_substeps");
  rest.in_muscles->max_depth_m = 0;
  rest.shared_faces[0].triangles = 2000;
  EXPECT_EQ(
      only_suspicion(at_the_limits(), rest),
      "100 % of the triangles of iliacus are those of psoas before the first frame (limit 1 %): is one mesh named "
      "twice?");
}

TEST(OutcomeLimits, ABackendThatMissesMoreThanItDeclaresIsSuspect) {
  Outcome outcome = at_the_limits();
  outcome.true_contacts = 587;
  outcome.missed_beyond = 170;
  outcome.max_missed_m = 0.0034;
  EXPECT_EQ(
      only_suspicion(outcome),
      "fcl missed 170 of 587 contacts (29 %, limit 1 %) by more than it declares, up to 3.4 mm deep: take another "
      "backend or a finer one");
}

TEST(OutcomeLimits, WhatAJudgementLeavesOpenIsNotWithinTheLimit) {
  Outcome outcome = at_the_limits();
  outcome.max_surface_depth_bound_m = 0.02;
  EXPECT_TRUE(suspicions(outcome, muscle()).empty()) << "every judgement was complete";
  outcome.open_judgements = 3;
  EXPECT_EQ(only_suspicion(outcome),
            "the surface may be 20 mm deep in a bone (limit 0.25 mm, 25 % of the bone's thickness), as the Referee's "
            "budget did not suffice for 3 frames: take more substeps, which pay for it");
  outcome.max_surface_depth_bound_m = 0.0002;
  EXPECT_TRUE(suspicions(outcome, muscle()).empty());
  outcome.worst_depth = depth_of(0.005);
  outcome.max_surface_depth_bound_m = 0.02;
  EXPECT_NE(only_suspicion(outcome).find("is 5 mm deep"), std::string::npos);
}

TEST(OutcomeLimits, AFigureThatIsNoNumberIsBeyondItsLimit) {
  Outcome outcome = at_the_limits();
  outcome.p99_edge_stretch = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(suspicions(outcome, muscle()).size(), 1U);
}

TEST(OutcomeLimits, OneLongEdgeIsANote) {
  Outcome outcome = at_the_limits();
  outcome.max_edge_stretch = 4.21;
  outcome.p99_edge_stretch = 1.5;
  outcome.when_max_stretch = {12, 0};
  EXPECT_TRUE(suspicions(outcome, muscle()).empty());
  EXPECT_EQ(outcome_notes(outcome),
            (std::vector<std::string>{"the longest edge is 4.21 times as long as at rest in frame "
                                      "12; 99 of 100 are at most 1.5 times"}));
  outcome.max_edge_stretch = 4;
  EXPECT_TRUE(outcome_notes(outcome).empty());
}

TEST(OutcomeLimits, EachHasANameAMeaningAndAReason) {
  std::set<std::string_view> names;
  for (const OutcomeLimit& limit : outcome_limits()) {
    EXPECT_TRUE(names.insert(limit.info.name).second);
    EXPECT_FALSE(limit.info.help.empty());
    EXPECT_FALSE(limit.why.empty());
    EXPECT_EQ(outcome_limit(limit.info.name), limit.limit);
  }
}

}  // namespace
}  // namespace musclebench
