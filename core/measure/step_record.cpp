#include "core/measure/step_record.hpp"

#include <array>
#include <cmath>

#include <fmt/format.h>

namespace musclebench {

namespace {

std::string text(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

template <typename Integer>
std::string text_if(bool known, Integer value) {
  return known ? fmt::format("{}", value) : "";
}

using Record = StepRecord;

std::string text_if_judged(const Record& record, double value) { return record.judged ? text(value) : ""; }

constexpr std::array<Column<StepRecord>, 42> columns{{
    {{"frame", "", "1 for the first"}, [](const Record& r) { return fmt::format("{}", r.frame); }},
    {{"angle_deg", "deg", "of the bone that turns most"}, [](const Record& r) { return text(r.angle_deg); }},
    {{"warm_up", "", "1: left out of medians"}, [](const Record& r) { return std::string(r.warm_up ? "1" : "0"); }},
    {{effect_column, "ns", "time of an effect of the scene, one column each, such as bending_ns"}, nullptr},
    {{"predict_ns", "ns", "time of the prediction, and of handing the positions to the backend"},
     [](const Record& r) { return fmt::format("{}", r.times.predict_ns); }},
    {{"update_ns", "ns", "collision time: the backend is told poses and positions; sum over the frame's steps"},
     [](const Record& r) { return fmt::format("{}", r.times.update_ns); }},
    {{"detect_ns", "ns", "collision time: detection; sum over the frame's steps"},
     [](const Record& r) { return fmt::format("{}", r.times.detect_ns); }},
    {{"respond_ns", "ns", "collision time: the response; sum over the frame's steps"},
     [](const Record& r) { return fmt::format("{}", r.times.respond_ns); }},
    {{stage_column, "ns", "time of a contact stage of the scene, one column each, such as muscle_contact_ns"}, nullptr},
    {{"finish_ns", "ns", "time of the velocity update"},
     [](const Record& r) { return fmt::format("{}", r.times.finish_ns); }},
    {{"frame_ns", "ns", "the whole loop; reading, judging, recording and writing are outside"},
     [](const Record& r) { return fmt::format("{}", r.times.frame_ns); }},
    {{"recording_ns", "ns", "copies for the Referee, one a frame"},
     [](const Record& r) { return fmt::format("{}", r.times.recording_ns); }},
    {{"contacts", "", "with bones, in the frame's last detection; with those in a margin"},
     [](const Record& r) { return fmt::format("{}", r.contacts); }},
    {{"nodes_inside", "", "free nodes truly inside a bone at the end of the frame"},
     [](const Record& r) { return text_if(r.judged, r.depth.nodes_inside); }},
    {{"max_depth_m", "m", "true depth of the deepest of them"},
     [](const Record& r) { return text_if_judged(r, r.depth.max_depth_m); }},
    {{"p99_depth_m", "m", "99th percentile of their depths"},
     [](const Record& r) { return text_if_judged(r, r.depth.p99_depth_m); }},
    {{"mean_depth_m", "m", "mean of their depths"},
     [](const Record& r) { return text_if_judged(r, r.depth.mean_depth_m); }},
    {{"missed_contacts", "", "true contacts that the last detection lacks"},
     [](const Record& r) { return text_if(r.judged, r.difference.missed); }},
    {{"false_contacts", "", "contacts of the last detection that are not true"},
     [](const Record& r) { return text_if(r.judged, r.difference.false_contacts); }},
    {{"missed_beyond_bound", "", "missed contacts that are deeper than the backend declares that it may miss"},
     [](const Record& r) { return text_if(r.judged, r.missed_beyond); }},
    {{"max_missed_m", "m", "true depth of the deepest of them"},
     [](const Record& r) { return text_if_judged(r, r.max_missed_m); }},
    {{"volume_m3", "m3", "of the muscle at the end of the frame; of several their sum"},
     [](const Record& r) { return text(sum_of(r.volumes_m3)); }},
    {{"resident_bytes", "bytes", "memory of the process without the Referee"},
     [](const Record& r) { return text_if(r.resident_bytes > 0, r.resident_bytes); }},
    {{"surface_depth_m", "m",
      "deepest point of a muscle triangle in a bone that was found; a ridge can cut a face whose "
      "nodes are all outside"},
     [](const Record& r) { return text(r.surface_depth_m); }},
    {{"bone_vertex_depth_m", "m", "deepest bone vertex in the muscle that was found"},
     [](const Record& r) { return text(r.bone_vertex_depth_m); }},
    {{"tunnelled_nodes", "",
      "nodes that went into a bone through one face and out through one that faces the other way, "
      "and have not come back"},
     [](const Record& r) { return text_if(r.judged, r.tunnelled_nodes); }},
    {{"stuck_nodes", "", "nodes that a false contact held in this frame"},
     [](const Record& r) { return text_if(r.judged, r.stuck_nodes); }},
    {{"surface_depth_bound_m", "m",
      "no point of a muscle triangle is deeper; exceeds surface_depth_m by more than its "
      "tolerance where the Referee's budget was spent"},
     [](const Record& r) { return text(r.surface_depth_bound_m); }},
    {{"bone_vertex_depth_bound_m", "m", "no bone vertex is deeper in the muscle"},
     [](const Record& r) { return text(r.bone_vertex_depth_bound_m); }},
    {{"judgement_complete", "", "0: the Referee's budget did not suffice, the two bounds say what is left open"},
     [](const Record& r) { return text_if(r.judged, r.judgement_complete ? 1 : 0); }},
    {{"max_edge_stretch", "", "longest edge over its length at rest"},
     [](const Record& r) { return text(r.edge_stretch.max); }},
    {{"p99_edge_stretch", "", "99th percentile of edge length over length at rest"},
     [](const Record& r) { return text(r.edge_stretch.p99); }},
    {{"self_intersecting_triangles", "",
      "muscle triangles that pass through others of the same muscle; in judged frames as often as the Referee's "
      "budget allows, in the frames of --snapshots and the last always"},
     [](const Record& r) {
       return text_if(r.self_intersecting_triangles.has_value(), r.self_intersecting_triangles.value_or(0));
     }},
    {{"bone_crossing_triangles", "",
      "muscle triangles that pass through a bone, without those that are attached to it; tested as the one before"},
     [](const Record& r) { return text_if(r.bone_crossings.has_value(), r.bone_crossings.value_or(0)); }},
    {{"muscle_crossing_triangles", "",
      "muscle triangles that pass through another muscle, of each pair those of the first; tested as the one before"},
     [](const Record& r) { return text_if(r.muscle_crossings.has_value(), r.muscle_crossings.value_or(0)); }},
    {{"involuntary_switches", "", "times that the scheduler gave the CPU to others while the frame was timed"},
     [](const Record& r) { return fmt::format("{}", r.involuntary_switches); }},
    {{"muscle_contacts", "", "nodes that the last detection between muscles found in other muscles"},
     [](const Record& r) { return text_if(r.muscle_contacts.has_value(), r.muscle_contacts.value_or(0)); }},
    {{"nodes_inside_muscles", "", "nodes truly inside another muscle that theirs touches, at the end of the frame"},
     [](const Record& r) { return text_if(r.in_muscles.has_value(), r.in_muscles ? r.in_muscles->nodes_inside : 0); }},
    {{"max_muscle_depth_m", "m", "true depth of the deepest of them"},
     [](const Record& r) { return r.in_muscles ? text(r.in_muscles->max_depth_m) : std::string(); }},
    {{"muscle_surface_depth_m", "m",
      "deepest point of a muscle triangle in another muscle that it touches; in frames that were tested for crossings"},
     [](const Record& r) { return text(r.muscle_surface_depth_m); }},
    {{"passed_nodes", "", "nodes that went through another muscle that theirs touches since the last frame"},
     [](const Record& r) { return text_if(r.passed_nodes.has_value(), r.passed_nodes.value_or(0)); }},
    {{"judging_ns", "ns", "time of the Referee, outside of the frame"},
     [](const Record& r) { return text_if(r.judged, r.judging_ns); }},
}};

}  // namespace

std::span<const Column<StepRecord>> run_columns() { return columns; }

void write_frames_csv(std::ostream& out, const std::vector<std::string>& effect_names,
                      const std::vector<std::string>& stage_names, const std::vector<StepRecord>& records) {
  std::string line;
  const auto append = [&line](const std::string& cell) { line += line.empty() ? cell : "," + cell; };
  for (const Column<StepRecord>& column : columns) {
    if (column.cell != nullptr) {
      append(std::string(column.info.name));
    } else {
      for (const std::string& name : column.info.name == effect_column ? effect_names : stage_names) {
        append(name + "_ns");
      }
    }
  }
  out << line << '\n';
  for (const StepRecord& record : records) {
    line.clear();
    for (const Column<StepRecord>& column : columns) {
      if (column.cell != nullptr) {
        append(column.cell(record));
      } else {
        const bool of_effects = column.info.name == effect_column;
        for (const Nanoseconds ns : of_effects ? record.times.effects_ns : record.times.stages_ns) {
          append(fmt::format("{}", ns));
        }
      }
    }
    out << line << '\n';
  }
}

}  // namespace musclebench
