#include "bench/results/replay_output.hpp"

#include <array>

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
  json["machine_state"] = json_of(result.machine);
  json["structure_bytes"] = result.structure_bytes;
  json["structures"] = result.structures_loaded ? "loaded" : "built";
  json["build_ns"] = result.build_ns;
  json["accuracy"] = json_of(result.accuracy);
  json["contact_hash"] = result.contact_hash;
  json["wall_ns"] = result.wall_ns;
  json["frames"] = result.records.size();
  return json;
}

using Record = ReplayRecord;

template <typename Value>
std::string text(Value value) {
  return fmt::format("{}", value);
}

/// Empty where the Referee did not look.
template <auto member>
std::string figure(const Record& record) {
  return record.accuracy ? text(*record.accuracy.*member) : "";
}

/// Empty where nothing was measured, either.
template <auto errors, auto member>
std::string statistic(const Record& record) {
  if (!record.accuracy || !((*record.accuracy).*errors)) return "";
  return text(*((*record.accuracy).*errors).*member);
}

constexpr auto columns_of_replay = std::to_array<Column<ReplayRecord>>({
    {{"frame", "", "of the recording, 1 for the first"}, [](const Record& r) { return text(r.frame); }},
    {{"angle_deg", "deg", "of the bone that turns most"}, [](const Record& r) { return text(r.angle_deg); }},
    {{"warm_up", "", "1: left out of medians"}, [](const Record& r) { return text(r.warm_up ? 1 : 0); }},
    {{"iterations", "", "collision steps of the frame"}, [](const Record& r) { return text(r.iterations); }},
    {{"update_ns", "ns", "the backend is told poses and positions; sum over the steps"},
     [](const Record& r) { return text(r.update_ns); }},
    {{"detect_ns", "ns", "detection; sum over the steps"}, [](const Record& r) { return text(r.detect_ns); }},
    {{"respond_ns", "ns", "the response; sum over the steps"}, [](const Record& r) { return text(r.respond_ns); }},
    {{"contacts", "", "answered; sum over the steps"}, [](const Record& r) { return text(r.contacts); }},
    {{"true_contacts", "", "by the Referee"}, figure<&Accuracy::true_contacts>},
    {{"missed_contacts", "", "true ones that were not answered"}, figure<&Accuracy::missed_contacts>},
    {{"false_contacts", "", "answered ones that are not true"}, figure<&Accuracy::false_contacts>},
    {{"measured_contacts", "", "true and answered ones within --band-mm of the surface"},
     figure<&Accuracy::measured_contacts>},
    {{"max_depth_error_m", "m",
      "over the measured contacts: the smallest error of signed distance that an answer admits"},
     statistic<&Accuracy::depth_error_m, &ErrorStatistics::max>},
    {{"p99_depth_error_m", "m", "99th percentile of it"}, statistic<&Accuracy::depth_error_m, &ErrorStatistics::p99>},
    {{"mean_depth_error_m", "m", "mean of it"}, statistic<&Accuracy::depth_error_m, &ErrorStatistics::mean>},
    {{"max_normal_error_deg", "deg", "angle between the answered normal and the Referee's"},
     statistic<&Accuracy::normal_error_deg, &ErrorStatistics::max>},
    {{"p99_normal_error_deg", "deg", "99th percentile of it"},
     statistic<&Accuracy::normal_error_deg, &ErrorStatistics::p99>},
    {{"mean_normal_error_deg", "deg", "mean of it"}, statistic<&Accuracy::normal_error_deg, &ErrorStatistics::mean>},
    {{"involuntary_switches", "", "times that the scheduler gave the CPU to others while the frame was timed"},
     [](const Record& r) { return text(r.involuntary_switches); }},
});

}  // namespace

std::span<const Column<ReplayRecord>> replay_columns() { return columns_of_replay; }

std::string replay_id(const ReplayCase& replay) { return id_of(json_of_replay(replay), replay.scene); }

void write_replay(const fs::path& folder, const ReplayCase& replay, const ReplayResult& result,
                  const RecordingHeader& header, const fs::path& recording) {
  write_result_folder(folder, [&](const fs::path& part) {
    OutputFile frames(part / "frames.csv");
    write_table(frames.stream(), replay_columns(), std::span<const ReplayRecord>(result.records));
    frames.close();
    OutputFile json(part / "run.json");
    json.stream() << text_of(manifest(replay, result, header, recording), 2) << '\n';
    json.close();
  });
}

}  // namespace musclebench
