#include "core/measure/outcome.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

MuscleAtRest at_rest(double volume_m3, double pressure = 1) {
  MuscleAtRest rest;
  rest.volumes_m3 = {volume_m3};
  rest.pressure = pressure;
  return rest;
}

StepRecord judged(double depth_m, double surface_m, double vertex_m, int tunnelled, int stuck) {
  StepRecord record;
  record.judged = true;
  record.depth.max_depth_m = depth_m;
  record.surface_depth_m = surface_m;
  record.bone_vertex_depth_m = vertex_m;
  record.tunnelled_nodes = tunnelled;
  record.stuck_nodes = stuck;
  record.volumes_m3 = {2};
  return record;
}

TEST(Outcome, OverTheRun) {
  std::vector<StepRecord> records{judged(0.1, 0.3, 0, 2, 0), judged(0.2, 0.2, 0.5, 3, 7), judged(0, 0, 0, 1, 4)};
  records[0].times.update_ns = 1;
  records[1].times.detect_ns = 20;
  records[2].times.respond_ns = 300;
  records[0].times.frame_ns = 1000;
  records[2].times.frame_ns = 4000;
  records[0].volumes_m3 = {1.5};
  records[2].volumes_m3 = {2.25};
  const Outcome outcome = outcome_of(records, at_rest(2));
  EXPECT_EQ(outcome.max_depth_m, 0.2);
  EXPECT_EQ(outcome.max_surface_depth_m, 0.5);
  EXPECT_EQ(outcome.tunnelled_nodes, 3);
  EXPECT_EQ(outcome.stuck_nodes, 7);
  EXPECT_EQ(outcome.max_volume_error, 0.25);
  EXPECT_EQ(outcome.final_volume_error, 0.125);
  EXPECT_EQ(outcome.collision_ns, 321);
  EXPECT_EQ(outcome.loop_ns, 5000);
}

TEST(Outcome, PercentileByNearestRank) {
  std::vector<StepRecord> records;
  for (int i = 200; i > 0; --i) records.push_back(judged(i, 2 * i, 0, 0, 0));
  EXPECT_EQ(outcome_of(records, at_rest(2)).p99_depth_m, 198);
  EXPECT_EQ(outcome_of(records, at_rest(2)).p99_surface_depth_m, 396);
  records.resize(1);
  EXPECT_EQ(outcome_of(records, at_rest(2)).p99_depth_m, 200);
}

TEST(Outcome, AMuscleWoundInwardsHasTheSameVolumeError) {
  StepRecord record;
  record.volumes_m3 = {-1.5};
  EXPECT_EQ(outcome_of(std::vector{record}, at_rest(-2)).final_volume_error, 0.25);
  EXPECT_EQ(outcome_of(std::vector{record}, at_rest(-2)).turned_inside_out, false);
}

std::vector<StepRecord> with_volumes(std::initializer_list<double> volumes_m3) {
  std::vector<StepRecord> records;
  for (const double volume_m3 : volumes_m3) records.emplace_back().volumes_m3 = {volume_m3};
  return records;
}

TEST(Outcome, TheVolumeErrorIsAgainstTheTarget) {
  // While it moves from 2 to 3 at the start it is no error not to be there yet; to leave again is one.
  const Outcome outcome = outcome_of(with_volumes({2.25, 2.75, 3, 3.375, 2.875, 3}), at_rest(2, 1.5));
  EXPECT_EQ(outcome.max_volume_error, 0.125);
  EXPECT_EQ(outcome.final_volume_error, 0);
  EXPECT_EQ(outcome_of(with_volumes({2.25, 2.75, 2.875}), at_rest(2, 1.5)).max_volume_error, 0.125 / 3)
      << "that it never gets there is an error";
  EXPECT_EQ(outcome_of(with_volumes({2.25, 2, 2}), at_rest(2)).max_volume_error, 0.125);
}

TEST(Outcome, AnOpenSurfaceHasNoVolumeThatCouldBeOff) {
  MuscleAtRest rest = at_rest(2);
  rest.are_open = {true};
  const Outcome outcome = outcome_of(with_volumes({2, -2, 9}), rest);
  EXPECT_FALSE(outcome.max_volume_error || outcome.final_volume_error || outcome.turned_inside_out);
  rest.are_open = {false};
  EXPECT_EQ(outcome_of(with_volumes({2, 9}), rest).max_volume_error, 3.5);
}

TEST(Outcome, TurnedInsideOut) {
  const Outcome outcome = outcome_of(with_volumes({2, -2, 2}), at_rest(2));
  EXPECT_EQ(outcome.turned_inside_out, true);
  EXPECT_EQ(outcome.max_volume_error, 2);
}

TEST(Outcome, TheLargestStretchAndTheLastNodesInside) {
  std::vector<StepRecord> records{judged(0.1, 0.3, 0, 0, 0), judged(0.2, 0.2, 0.5, 0, 0)};
  records[0].edge_stretch = {3, 1.5};
  records[1].edge_stretch = {2, 1.75};
  records[0].depth.nodes_inside = 7;
  records[1].depth.nodes_inside = 5;
  records[0].surface_depth_bound_m = 0.75;
  records[0].judgement_complete = false;
  records[1].bone_vertex_depth_bound_m = 0.5;
  records[1].self_intersecting_triangles = 12;
  const Outcome outcome = outcome_of(records, at_rest(2));
  EXPECT_EQ(outcome.max_edge_stretch, 3);
  EXPECT_EQ(outcome.p99_edge_stretch, 1.75);
  EXPECT_EQ(outcome.nodes_inside_at_end, 5);
  EXPECT_EQ(outcome.max_surface_depth_bound_m, 0.75);
  EXPECT_EQ(outcome.open_judgements, 1);
  EXPECT_EQ(outcome.self_intersecting_triangles, 12);
}

TEST(Outcome, TheFrameWithMostCrossingsOfEachPair) {
  std::vector<StepRecord> records(4, judged(0, 0, 0, 0, 0));
  for (std::size_t i = 0; i < 4; ++i) {
    records[i].frame = static_cast<int>(i) + 1;
    records[i].angle_deg = 10.0 * records[i].frame;
  }
  const auto tested = [](StepRecord& record, std::vector<int> counts) {
    record.bone_crossings = counts[0];
    record.muscle_crossings = counts[1];
    record.self_intersecting_triangles = counts[2];
    record.beyond_rest = {counts[0], std::max(0, counts[1] - 2), 0};
    record.crossings = std::move(counts);
  };
  tested(records[0], {0, 7, 0});
  tested(records[2], {9, 2, 0});
  tested(records[3], {9, 1, 0});
  MuscleAtRest rest = at_rest(2);
  rest.crossing_pairs = {{0, CrossedSurface::bone, 0}, {0, CrossedSurface::muscle, 1}, {0, CrossedSurface::itself, 0}};
  rest.crossings = {1, 2, 3};
  const Outcome outcome = outcome_of(records, rest);
  EXPECT_EQ(outcome.crossing_frames, 3);
  ASSERT_EQ(outcome.crossings.size(), 3U);
  EXPECT_EQ(outcome.crossings[0].triangles, 9);
  EXPECT_EQ(outcome.crossings[0].frame, 3) << "the first with so many";
  EXPECT_EQ(outcome.crossings[0].angle_deg, 30);
  EXPECT_EQ(outcome.crossings[1].frame, 1);
  EXPECT_EQ(outcome.crossings[2].frame, 0);
  ASSERT_EQ(outcome.beyond_rest.size(), 3U);
  EXPECT_EQ(outcome.beyond_rest[0].triangles, 9);
  EXPECT_EQ(outcome.beyond_rest[1].triangles, 5);
  EXPECT_EQ(outcome.beyond_rest[1].frame, 1);
  EXPECT_EQ(outcome.bone_crossings, 9);
  EXPECT_EQ(outcome.muscle_crossings, 7);
  EXPECT_EQ(outcome.bone_crossings_at_rest, 1);
  EXPECT_EQ(outcome.muscle_crossings_at_rest, 2);
  EXPECT_EQ(outcome.self_intersecting_triangles_at_rest, 3);
}

TEST(Outcome, TheWorstDepthIsTheLargestPartOfItsLimit) {
  MuscleAtRest rest = at_rest(2);
  rest.muscles = {{"large", 1, 200, 10}, {"small", 1, 100, 10}};  // at most 1 and 0.5 deep
  rest.bones = {{"thick", 40}, {"needle", 0.4}};                  // and 0.1 in the needle
  std::vector<StepRecord> records{judged(0, 0.6, 0, 0, 0), judged(0.3, 0.5, 0.07, 0, 0), judged(0, 0, 0, 0, 0)};
  for (std::size_t i = 0; i < records.size(); ++i) records[i].frame = static_cast<int>(i) + 1;
  records[0].surface_bodies = records[1].surface_bodies = {0, 0};
  records[1].bone_vertex_bodies = {0, 1};
  records[1].in_muscles = DepthStatistics{1, 0.1, 0, 0};
  records[1].in_muscles_bodies = {0, 1};
  records[2].in_muscles = DepthStatistics{1, 0, 0, 0};
  records[2].muscle_surface_depth_m = 0.2;
  records[2].muscle_surface_bodies = {1, 0};
  const Outcome outcome = outcome_of(records, rest);
  ASSERT_TRUE(outcome.worst_depth && outcome.worst_muscle_depth);
  EXPECT_TRUE(outcome.worst_depth->is_bone_vertex) << "0.7 of its limit, where 0.6 in the thick bone is 0.6";
  EXPECT_EQ(outcome.worst_depth->bodies.other, 1);
  EXPECT_EQ(outcome.worst_depth->depth_m, 0.07);
  EXPECT_NEAR(outcome.worst_depth->limit.depth_m, 0.1, 1e-12);
  EXPECT_EQ(outcome.worst_depth->when.frame, 2);
  EXPECT_EQ(outcome.worst_depth->node_depth_m, 0.3);
  EXPECT_FALSE(outcome.worst_depth->is_beyond());
  EXPECT_EQ(outcome.worst_muscle_depth->depth_m, 0.2);
  EXPECT_EQ(outcome.worst_muscle_depth->bodies.muscle, 1);
  EXPECT_EQ(outcome.worst_muscle_depth->limit.depth_m, 0.5) << "the smaller muscle's";
  EXPECT_EQ(outcome.worst_muscle_depth->node_depth_m, 0);
  EXPECT_EQ(outcome.max_muscle_surface_depth_m, 0.2);
}

TEST(Outcome, WhatWasNotMeasuredIsMissing) {
  StepRecord lost;  // not judged, as it blew up
  lost.volumes_m3 = {std::numeric_limits<double>::quiet_NaN()};
  const Outcome nothing = outcome_of(std::vector{lost}, at_rest(2));
  for (const auto& figure : {nothing.max_depth_m, nothing.p99_depth_m, nothing.max_surface_depth_m,
                             nothing.p99_surface_depth_m, nothing.max_volume_error, nothing.final_volume_error}) {
    EXPECT_FALSE(figure.has_value());
  }
  EXPECT_FALSE(nothing.tunnelled_nodes.has_value());
  EXPECT_FALSE(nothing.stuck_nodes.has_value());

  const Outcome before = outcome_of(std::vector{judged(0.1, 0.2, 0, 3, 4), lost}, at_rest(2));
  EXPECT_EQ(before.max_depth_m, 0.1);
  EXPECT_EQ(before.tunnelled_nodes, 3);
  EXPECT_EQ(before.max_volume_error, 0);
  EXPECT_FALSE(before.final_volume_error.has_value());
  EXPECT_FALSE(outcome_of({}, at_rest(2)).max_depth_m.has_value());
  EXPECT_FALSE(outcome_of(std::vector{judged(0, 0, 0, 0, 0)}, at_rest(0)).max_volume_error.has_value());
}

}  // namespace
}  // namespace musclebench
