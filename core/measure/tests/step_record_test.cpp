#include "core/measure/step_record.hpp"

#include <cmath>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> result(1);
  for (const char c : line) {
    if (c == ',') {
      result.emplace_back();
    } else {
      result.back() += c;
    }
  }
  return result;
}

struct Csv {
  std::vector<std::string> header;
  std::vector<std::string> row;

  explicit Csv(const StepRecord& record) {
    std::ostringstream out;
    write_frames_csv(out, {"volume"}, {"muscle_contact"}, {record});
    std::istringstream in(out.str());
    std::string line;
    std::getline(in, line);
    header = cells(line);
    std::getline(in, line);
    row = cells(line);
  }

  [[nodiscard]] std::string operator[](const std::string& column) const {
    for (std::size_t i = 0; i < header.size(); ++i) {
      if (header[i] == column) {
        return row.at(i);
      }
    }
    return "no such column";
  }
};

StepRecord record() {
  StepRecord r;
  r.frame = 3;
  r.angle_deg = 1.0 / 3;
  r.times.effects_ns = {17};
  r.times.stages_ns = {18};
  r.times.predict_ns = 1;
  r.times.update_ns = 2;
  r.times.detect_ns = 3;
  r.times.respond_ns = 4;
  r.times.finish_ns = 5;
  r.times.frame_ns = 6;
  r.times.recording_ns = 7;
  r.contacts = 8;
  r.judged = true;
  r.depth = {9, 0.1, 0.2, 0.3};
  r.difference = {10, 11};
  r.volumes_m3 = {1e-5};
  r.resident_bytes = 12;
  r.surface_depth_m = 0.4;
  r.bone_vertex_depth_m = 0.5;
  r.tunnelled_nodes = 13;
  r.stuck_nodes = 14;
  r.surface_depth_bound_m = 0.6;
  r.bone_vertex_depth_bound_m = 0.7;
  r.judgement_complete = false;
  r.edge_stretch = {1.5, 1.25};
  r.self_intersecting_triangles = 15;
  r.bone_crossings = 21;
  r.muscle_crossings = 22;
  r.involuntary_switches = 16;
  r.judging_ns = 17;
  r.muscle_contacts = 19;
  r.in_muscles = DepthStatistics{20, 0.8, 0.9, 1.0};
  return r;
}

TEST(FramesCsv, EveryFigureStandsUnderItsName) {
  const Csv csv(record());
  ASSERT_EQ(csv.header.size(), csv.row.size());
  const std::vector<std::pair<std::string, std::string>> expected = {{"frame", "3"},
                                                                     {"warm_up", "0"},
                                                                     {"volume_ns", "17"},
                                                                     {"predict_ns", "1"},
                                                                     {"update_ns", "2"},
                                                                     {"detect_ns", "3"},
                                                                     {"respond_ns", "4"},
                                                                     {"muscle_contact_ns", "18"},
                                                                     {"muscle_contacts", "19"},
                                                                     {"nodes_inside_muscles", "20"},
                                                                     {"max_muscle_depth_m", "0.8"},
                                                                     {"finish_ns", "5"},
                                                                     {"frame_ns", "6"},
                                                                     {"recording_ns", "7"},
                                                                     {"contacts", "8"},
                                                                     {"nodes_inside", "9"},
                                                                     {"max_depth_m", "0.1"},
                                                                     {"p99_depth_m", "0.2"},
                                                                     {"mean_depth_m", "0.3"},
                                                                     {"missed_contacts", "10"},
                                                                     {"false_contacts", "11"},
                                                                     {"volume_m3", "1e-05"},
                                                                     {"resident_bytes", "12"},
                                                                     {"surface_depth_m", "0.4"},
                                                                     {"bone_vertex_depth_m", "0.5"},
                                                                     {"tunnelled_nodes", "13"},
                                                                     {"stuck_nodes", "14"},
                                                                     {"surface_depth_bound_m", "0.6"},
                                                                     {"bone_vertex_depth_bound_m", "0.7"},
                                                                     {"judgement_complete", "0"},
                                                                     {"max_edge_stretch", "1.5"},
                                                                     {"p99_edge_stretch", "1.25"},
                                                                     {"self_intersecting_triangles", "15"},
                                                                     {"bone_crossing_triangles", "21"},
                                                                     {"muscle_crossing_triangles", "22"},
                                                                     {"involuntary_switches", "16"},
                                                                     {"judging_ns", "17"}};
  for (const auto& [column, value] : expected) {
    EXPECT_EQ(csv[column], value) << column;
  }
  EXPECT_EQ(std::stod(csv["angle_deg"]), 1.0 / 3);
}

TEST(FramesCsv, UnknownIsEmptyAndNothingNonFiniteIsWritten) {
  StepRecord r = record();
  r.judged = false;
  r.surface_depth_m = StepRecord().surface_depth_m;
  r.bone_vertex_depth_m = StepRecord().bone_vertex_depth_m;
  r.surface_depth_bound_m = StepRecord().surface_depth_bound_m;
  r.edge_stretch = {};
  r.self_intersecting_triangles.reset();
  r.volumes_m3 = {std::numeric_limits<double>::infinity()};
  r.angle_deg = std::nan("");
  r.resident_bytes = 0;
  const Csv csv(r);
  for (const char* column :
       {"nodes_inside", "max_depth_m", "missed_contacts", "volume_m3", "angle_deg", "resident_bytes", "surface_depth_m",
        "bone_vertex_depth_m", "tunnelled_nodes", "stuck_nodes", "surface_depth_bound_m", "judgement_complete",
        "max_edge_stretch", "self_intersecting_triangles", "judging_ns"}) {
    EXPECT_EQ(csv[column], "") << column;
  }
  EXPECT_EQ(csv["contacts"], "8");
}

}  // namespace
}  // namespace musclebench
