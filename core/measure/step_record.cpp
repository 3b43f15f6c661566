#include "core/measure/step_record.hpp"

#include <cmath>

#include <fmt/format.h>

namespace musclebench {

namespace {

std::string cell(double value) { return std::isfinite(value) ? fmt::format(",{}", value) : ","; }

template <typename Integer>
std::string cell_if(bool known, Integer value) {
  return known ? fmt::format(",{}", value) : ",";
}

}  // namespace

void write_frames_csv(std::ostream& out, const std::vector<std::string>& effect_names,
                      const std::vector<StepRecord>& records) {
  out << "frame,angle_deg,warm_up";
  for (const std::string& name : effect_names) {
    out << ',' << name << "_ns";
  }
  out << ",predict_ns,update_ns,detect_ns,respond_ns,finish_ns,frame_ns,recording_ns,contacts,nodes_inside,max_depth_m,"
         "p99_depth_m,"
         "mean_depth_m,missed_contacts,false_contacts,volume_m3,resident_bytes,surface_depth_m,bone_vertex_depth_m,"
         "tunnelled_nodes,stuck_nodes\n";
  for (const StepRecord& record : records) {
    const StageTimes& times = record.times;
    std::string line = fmt::format("{}{},{}", record.frame, cell(record.angle_deg), record.warm_up ? 1 : 0);
    for (const Nanoseconds ns : times.effects_ns) {
      line += fmt::format(",{}", ns);
    }
    line += fmt::format(",{},{},{},{},{},{},{},{}", times.predict_ns, times.update_ns, times.detect_ns,
                        times.respond_ns, times.finish_ns, times.frame_ns, times.recording_ns, record.contacts);
    line += cell_if(record.judged, record.depth.nodes_inside);
    for (const double depth : {record.depth.max_depth_m, record.depth.p99_depth_m, record.depth.mean_depth_m}) {
      line += record.judged ? cell(depth) : ",";
    }
    line += cell_if(record.judged, record.difference.missed) + cell_if(record.judged, record.difference.false_contacts);
    line += cell(record.volume_m3) + cell_if(record.resident_bytes > 0, record.resident_bytes);
    line += cell(record.surface_depth_m) + cell(record.bone_vertex_depth_m);
    line += cell_if(record.judged, record.tunnelled_nodes) + cell_if(record.judged, record.stuck_nodes);
    out << line << '\n';
  }
}

}  // namespace musclebench
