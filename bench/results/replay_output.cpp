#include "bench/results/replay_output.hpp"

#include <fmt/format.h>

#include "bench/results/manifest.hpp"
#include "bench/results/result_folder.hpp"
#include "core/base/output_file.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

Json json_of_replay(const ReplayCase& replay) {
  Json json = json_of_case(replay, "replay");
  json["warm_up_frames"] = replay.warm_up_frames;
  json["judged"] = replay.judge;
  json["stride"] = replay.stride;
  json["band_m"] = replay.band_m;
  json["recording_sha256"] = replay.recording.sha256;
  return json;
}

void add_statistics(Json& json, const std::optional<ErrorStatistics>& errors, std::string_view what) {
  const auto figure = [&](double ErrorStatistics::*member) { return errors ? Json(*errors.*member) : Json(nullptr); };
  json[fmt::format("max_{}", what)] = figure(&ErrorStatistics::max);
  json[fmt::format("p99_{}", what)] = figure(&ErrorStatistics::p99);
  json[fmt::format("mean_{}", what)] = figure(&ErrorStatistics::mean);
}

Json json_of(const std::optional<Accuracy>& accuracy) {
  if (!accuracy) {
    return nullptr;
  }
  Json json = {{"contacts", accuracy->contacts},
               {"true_contacts", accuracy->true_contacts},
               {"missed_contacts", accuracy->missed_contacts},
               {"false_contacts", accuracy->false_contacts},
               {"measured_contacts", accuracy->measured_contacts}};
  add_statistics(json, accuracy->depth_error_m, "depth_error_m");
  add_statistics(json, accuracy->normal_error_deg, "normal_error_deg");
  json["max_missed_depth_m"] = accuracy->max_missed_depth_m;
  json["max_false_distance_m"] = accuracy->max_false_distance_m;
  return json;
}

Json manifest(const ReplayCase& replay, const ReplayResult& result, const RecordingHeader& header,
              const fs::path& recording) {
  Json json = manifest_head(result.status, result.status_detail, json_of_replay(replay), replay.scene);
  json["recording"] = {{"file", recording.string()},
                       {"sha256", replay.recording.sha256},
                       {"bytes", replay.recording.bytes},
                       {"frames", header.frames()},
                       {"iterations", header.frames() * std::int64_t{header.steps_per_frame()}},
                       {"stride", replay.stride},
                       {"backend", header.backend},
                       {"build", header.build}};
  json["band_m"] = replay.band_m;
  json["structure_bytes"] = result.structure_bytes;
  json["structures"] = result.structures_loaded ? "loaded" : "built";
  json["build_ns"] = result.build_ns;
  json["accuracy"] = json_of(result.accuracy);
  json["contact_hash"] = result.contact_hash;
  json["wall_ns"] = result.wall_ns;
  json["frames"] = result.records.size();
  return json;
}

std::string cells_of(const std::optional<ErrorStatistics>& errors) {
  return errors ? fmt::format(",{},{},{}", errors->max, errors->p99, errors->mean) : ",,,";
}

std::string cells_of(const std::optional<Accuracy>& accuracy) {
  if (!accuracy) {
    return std::string(10, ',');
  }
  return fmt::format(",{},{},{},{}", accuracy->true_contacts, accuracy->missed_contacts, accuracy->false_contacts,
                     accuracy->measured_contacts) +
         cells_of(accuracy->depth_error_m) + cells_of(accuracy->normal_error_deg);
}

void write_frames(std::ostream& out, const std::vector<ReplayRecord>& records) {
  out << "frame,angle_deg,warm_up,iterations,update_ns,detect_ns,respond_ns,contacts,true_contacts,missed_contacts,"
         "false_contacts,measured_contacts,max_depth_error_m,p99_depth_error_m,mean_depth_error_m,max_normal_error_deg,"
         "p99_normal_error_deg,mean_normal_error_deg\n";
  for (const ReplayRecord& record : records) {
    out << fmt::format("{},{},{},{},{},{},{},{}", record.frame, record.angle_deg, record.warm_up ? 1 : 0,
                       record.iterations, record.update_ns, record.detect_ns, record.respond_ns, record.contacts)
        << cells_of(record.accuracy) << '\n';
  }
}

}  // namespace

std::string replay_id(const ReplayCase& replay) { return id_of(json_of_replay(replay), replay.scene); }

void write_replay(const fs::path& folder, const ReplayCase& replay, const ReplayResult& result,
                  const RecordingHeader& header, const fs::path& recording) {
  write_result_folder(folder, [&](const fs::path& part) {
    OutputFile frames(part / "frames.csv");
    write_frames(frames.stream(), result.records);
    frames.close();
    OutputFile json(part / "run.json");
    json.stream() << text_of(manifest(replay, result, header, recording), 2) << '\n';
    json.close();
  });
}

}  // namespace musclebench
