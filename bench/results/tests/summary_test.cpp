#include "bench/results/summary.hpp"

#include <utility>

#include <gtest/gtest.h>

#include "bench/results/tests/small_run.hpp"

namespace musclebench {
namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(MedianMs, OfAnEvenNumberIsTheMeanOfTheTwoInTheMiddle) {
  EXPECT_EQ(median_ms({4'000'000, 1'000'000, 2'000'000, 3'000'000}), "     2.500 ms");
  EXPECT_EQ(median_ms({}), "unknown (warm-up only)");
}

class RunSummary : public testing::Test {
 protected:
  [[nodiscard]] std::string text() const { return run_summary(m_run, m_result); }

  const Scene m_scene = plain_scene();
  const RunCase m_run = case_of(m_scene, "null");
  RunResult m_result;
};

TEST_F(RunSummary, SaysAllThatIsWrong) {
  m_result.status = "suspect";
  m_result.status_detail = "642 nodes tunnelled through a bone (limit 0)";
  m_result.outcome.max_depth_m = 0.0001;
  m_result.outcome.max_surface_depth_m = 0.00125;
  m_result.outcome.max_surface_depth_bound_m = 0.0035;
  m_result.outcome.open_judgements = 2;
  m_result.outcome.tunnelled_nodes = 642;
  m_result.outcome.stuck_nodes = 3;
  m_result.outcome.nodes_inside_at_rest = 11;
  m_result.outcome.nodes_inside_at_end = 12;
  m_result.outcome.max_volume_error = 0.537;
  m_result.outcome.turned_inside_out = true;
  m_result.outcome.max_edge_stretch = 4.25;
  m_result.outcome.p99_edge_stretch = 1.5;
  m_result.outcome.self_intersecting_triangles = 436;
  m_result.outcome.self_intersecting_triangles_at_rest = 1;
  m_result.outcome.muscle_crossings = 17;
  m_result.outcome.muscle_crossings_at_rest = 2;
  for (const char* part : {": suspect: 642 nodes tunnelled through a bone (limit 0)",
                           "0.100 mm, of the surface 1.250 mm or more, at most 3.500 mm (2 frames were judged in part)",
                           "642, at most 3 at once", "11 at rest, 12 at the end", "53.700 %, turned inside out",
                           "4.250 at most, 99 % up to 1.500", "436 at most, 1 at rest", "17 at most, 2 at rest"}) {
    EXPECT_TRUE(contains(text(), part)) << part << "\n" << text();
  }
}

TEST_F(RunSummary, TellsTorquesAndTheLargestContact) {
  EXPECT_FALSE(contains(text(), "torque"));
  for (const double torque_n_m : {0.5, -2.0, 1.0}) {
    ForceRow joint;
    joint.source = ForceSource::joint;
    joint.other = "femur";
    joint.torque_n_m = torque_n_m;
    m_result.forces.push_back(joint);
    ForceRow contact;
    contact.frame = static_cast<int>(10 * (torque_n_m + 3));
    contact.muscle = "ball";
    contact.other = "plate";
    contact.normal_n = 3 * torque_n_m;
    contact.peak_pressure_pa = 100 * torque_n_m;
    m_result.forces.push_back(contact);
  }
  EXPECT_TRUE(contains(text(), " -2 to 1 N m")) << text();
  EXPECT_TRUE(contains(text(), "3 N (ball on plate, frame 40)")) << text();
  EXPECT_TRUE(contains(text(), "100 Pa (ball on plate, frame 40)")) << text();
}

TEST_F(RunSummary, FramesThatWarmUpAreInNoMedian) {
  for (const auto& [frame_ms, warm_up] : {std::pair(90, true), {80, true}, {1, false}, {3, false}, {8, false}}) {
    StepRecord record;
    record.warm_up = warm_up;
    record.times.frame_ns = frame_ms * 1'000'000;
    record.times.detect_ns = frame_ms * 500'000;
    m_result.records.push_back(record);
  }
  EXPECT_TRUE(contains(text(), "frame, median                      3.000 ms")) << text();
  EXPECT_TRUE(contains(text(), "of it collision                    1.500 ms")) << text();
}

TEST_F(RunSummary, WhatIsUnknownIsNotZero) {
  m_result.outcome.max_volume_error = 0.01;
  EXPECT_TRUE(contains(text(), "unknown (not judged)"));
  EXPECT_FALSE(contains(text(), "0.000 mm"));
  EXPECT_FALSE(contains(text(), "tunnelled"));
  EXPECT_FALSE(contains(text(), "at rest"));
}

TEST(ProbeSummary, WhatNothingWasMeasuredOfIsADash) {
  const Scene scene = plain_scene();
  const ProbeCase what{static_cast<const Case&>(case_of(scene, "null"))};
  ProbeResult result;
  result.rows = {{"femur", "smooth", 100, 60, {3e-3, 2e-3, 1e-3, 1.5e-3}, 5}, {"femur", "sharp", 0, 0, {}, 0}};
  const std::string text = probe_summary(what, result);
  EXPECT_TRUE(contains(text, "3.000000     2.000000     1.000000     1.500000       5.000 %")) << text;
  EXPECT_TRUE(contains(text, "sharp         0            -            -            -            -             -"))
      << text;
  EXPECT_FALSE(contains(text, " 0.000000")) << text;
}

}  // namespace
}  // namespace musclebench
