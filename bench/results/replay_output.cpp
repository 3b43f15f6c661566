#include "bench/results/replay_output.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include <fmt/format.h>

#include "bench/results/manifest.hpp"
#include "bench/results/result_folder.hpp"
#include "core/base/output_file.hpp"
#include "core/base/table_file.hpp"

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

Json json_of(const Accuracy& accuracy) {
  Json json = {{"contacts", accuracy.contacts},
               {"true_contacts", accuracy.true_contacts},
               {"missed_contacts", accuracy.missed_contacts},
               {"false_contacts", accuracy.false_contacts},
               {"measured_contacts", accuracy.measured_contacts}};
  add_statistics(json, accuracy.depth_error_m, "depth_error_m");
  add_statistics(json, accuracy.normal_error_deg, "normal_error_deg");
  json["max_missed_depth_m"] = accuracy.max_missed_depth_m;
  json["max_false_distance_m"] = accuracy.max_false_distance_m;
  return json;
}

Json json_of(const std::optional<OffsetStatistics>& offsets) {
  const auto figure = [&](auto OffsetStatistics::*member) {
    return offsets ? Json((*offsets).*member) : Json(nullptr);
  };
  return {{"sites", offsets ? offsets->sites : 0},
          {"open_sites", offsets ? offsets->open_sites : 0},
          {"p99_offset_m", figure(&OffsetStatistics::p99_offset_m)},
          {"max_offset_m", figure(&OffsetStatistics::max_offset_m)},
          {"p99_inward_m", figure(&OffsetStatistics::p99_inward_m)},
          {"max_inward_m", figure(&OffsetStatistics::max_inward_m)},
          {"p99_outward_m", figure(&OffsetStatistics::p99_outward_m)},
          {"max_outward_m", figure(&OffsetStatistics::max_outward_m)}};
}

/// Of all sites, of each pair of muscle and bone, and of each difficulty.
Json json_of(const std::optional<SurfaceOffsets>& offsets, const Scene& scene) {
  if (!offsets) return nullptr;
  Json json = json_of(offsets->all);
  json["of_pairs"] = Json::array();
  for (std::size_t pair = 0; pair < offsets->of_pairs.size(); ++pair) {
    Json own = {{"muscle", scene.muscles[pair % scene.muscles.size()].body.name},
                {"bone", scene.bones[pair / scene.muscles.size()].name}};
    own.update(json_of(offsets->of_pairs[pair]));
    json["of_pairs"].push_back(own);
  }
  json["of_difficulties"] = Json::array();
  for (std::size_t kind = 0; kind < contact_difficulties.size(); ++kind) {
    Json own = {{"difficulty", contact_difficulties[kind]}};
    own.update(json_of(offsets->of_difficulties[kind]));
    json["of_difficulties"].push_back(own);
  }
  return json;
}

/// What one of several muscles is told of all bones.
Json json_of_muscles(const ReplayCase& replay, const ReplayResult& result) {
  const std::vector<Accuracy>& accuracy = result.accuracy_of_muscles;
  Json list = Json::array();
  for (std::size_t i = 0; i < accuracy.size(); ++i) {
    Json own = {{"muscle", replay.scene.muscles[i].body.name}};
    own.update(json_of(accuracy[i]));
    own["surface_offset"] = result.offsets ? json_of(result.offsets->of_muscles[i]) : Json(nullptr);
    list.push_back(own);
  }
  return list;
}

/// What was found between muscles; zero and empty where nothing was asked.
void add_muscles(Json& json, const ReplayCase& replay, const std::optional<MuscleReplay>& muscles) {
  json["muscle_structure_bytes"] = muscles ? muscles->structure_bytes : 0;
  json["muscle_build_ns"] = muscles ? muscles->build_ns : 0;
  json["muscle_contact_hash"] = muscles ? Json(muscles->contact_hash) : Json(nullptr);
  json["muscle_accuracy"] = Json::array();
  for (std::size_t pair = 0; muscles && pair < muscles->accuracy.size(); ++pair) {
    Json own = {{"muscles", names_of(replay.scene, replay.scene.muscle_pairs[pair].muscles)}};
    own.update(json_of(muscles->accuracy[pair]));
    json["muscle_accuracy"].push_back(own);
  }
}

Json manifest(const ReplayCase& replay, const ReplayResult& result, const RecordingHeader& header,
              const fs::path& recording) {
  Json json = manifest_head(result.status, result.status_detail, json_of_replay(replay), replay);
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
  json["pruned"] = json_of(result.pruned, replay.scene);
  add_origin(json, result.structures);
  json["build_ns"] = result.build_ns;
  json["accuracy"] = result.accuracy ? json_of(*result.accuracy) : Json(nullptr);
  json["surface_offset"] = json_of(result.offsets, replay.scene);
  json["accuracy_of_muscles"] = json_of_muscles(replay, result);
  // No number where nothing is declared: JSON has no infinity.
  json["declared"] = {{"missed_depth_m", result.declared.missed_depth_m},
                      {"false_distance_m", result.declared.false_distance_m}};
  json["contact_hash"] = result.contact_hash;
  json["queries_hash"] = result.queries_hash;
  add_muscles(json, replay, result.muscles);
  json["wall_ns"] = result.wall_ns;
  json["frames"] = result.records.size();
  return json;
}

template <typename Value>
std::string text(Value value) {
  return fmt::format("{}", value);
}

std::string text(std::optional<Nanoseconds> time_ns) { return time_ns ? text(*time_ns) : std::string(); }

const std::optional<Accuracy>& accuracy_in(const ReplayRecord& record) { return record.accuracy; }
const std::optional<Accuracy>& accuracy_in(const MuscleReplayRow& row) { return row.answers.accuracy; }
const std::optional<Accuracy>& accuracy_in(const PairReplayRow& row) { return row.pair.accuracy; }

/// Empty where the Referee did not look.
template <auto member>
constexpr auto figure = [](const auto& row) {
  const std::optional<Accuracy>& accuracy = accuracy_in(row);
  return accuracy ? text(*accuracy.*member) : std::string();
};

/// Empty where nothing was measured, either.
template <auto errors, auto member>
constexpr auto statistic = [](const auto& row) {
  const std::optional<Accuracy>& accuracy = accuracy_in(row);
  return accuracy && (*accuracy).*errors ? text(*((*accuracy).*errors).*member) : std::string();
};

/// What the Referee tells of a row.
template <typename Row>
constexpr auto columns_of_accuracy = std::to_array<Column<Row>>({
    {{"true_contacts", "", "by the Referee"}, figure<&Accuracy::true_contacts>},
    {{"missed_contacts", "", "true ones that were not answered"}, figure<&Accuracy::missed_contacts>},
    {{"false_contacts", "", "answered ones that are not true"}, figure<&Accuracy::false_contacts>},
    {{"measured_contacts", "", "both true and answered, with a depth, and no deeper than --band-mm"},
     figure<&Accuracy::measured_contacts>},
    {{"max_depth_error_m", "m",
      "of the measured contacts: largest difference between the answered depth and the Referee's"},
     statistic<&Accuracy::depth_error_m, &ErrorStatistics::max>},
    {{"p99_depth_error_m", "m", "99th percentile of it"}, statistic<&Accuracy::depth_error_m, &ErrorStatistics::p99>},
    {{"mean_depth_error_m", "m", "mean of it"}, statistic<&Accuracy::depth_error_m, &ErrorStatistics::mean>},
    {{"max_normal_error_deg", "deg", "angle between the answered normal and the Referee's"},
     statistic<&Accuracy::normal_error_deg, &ErrorStatistics::max>},
    {{"p99_normal_error_deg", "deg", "99th percentile of it"},
     statistic<&Accuracy::normal_error_deg, &ErrorStatistics::p99>},
    {{"mean_normal_error_deg", "deg", "mean of it"}, statistic<&Accuracy::normal_error_deg, &ErrorStatistics::mean>},
});

template <typename Row, std::size_t... sizes>
constexpr auto joined(const std::array<Column<Row>, sizes>&... parts) {
  std::array<Column<Row>, (sizes + ...)> all{};
  auto next = all.begin();
  ((next = std::copy(parts.begin(), parts.end(), next)), ...);
  return all;
}

constexpr auto columns_of_replay = joined(
    std::to_array<Column<ReplayRecord>>({
        {{"frame", "", "of the recording, 1 for the first"}, [](const ReplayRecord& r) { return text(r.frame); }},
        {{"angle_deg", "deg", "of the bone that turns most"}, [](const ReplayRecord& r) { return text(r.angle_deg); }},
        {{"warm_up", "", "1: left out of medians"}, [](const ReplayRecord& r) { return text(r.warm_up ? 1 : 0); }},
        {{"iterations", "", "collision steps of the frame"}, [](const ReplayRecord& r) { return text(r.iterations); }},
        {{"update_ns", "ns", "the backend is told poses and positions; sum over the steps"},
         [](const ReplayRecord& r) { return text(r.update_ns); }},
        {{"detect_ns", "ns", "detection; sum over the steps"}, [](const ReplayRecord& r) { return text(r.detect_ns); }},
        {{"respond_ns", "ns", "the response; sum over the steps"},
         [](const ReplayRecord& r) { return text(r.respond_ns); }},
        {{"contacts", "", "answered; sum over the steps"}, [](const ReplayRecord& r) { return text(r.contacts); }},
    }),
    columns_of_accuracy<ReplayRecord>,
    std::to_array<Column<ReplayRecord>>({
        {{"involuntary_switches", "", "times that the scheduler gave the CPU to others while the frame was timed"},
         [](const ReplayRecord& r) { return text(r.involuntary_switches); }},
    }));

constexpr auto columns_of_muscles =
    joined(std::to_array<Column<MuscleReplayRow>>({
               {{"frame", "", "of the recording, 1 for the first"},
                [](const MuscleReplayRow& r) { return text(r.frame.frame); }},
               {{"angle_deg", "deg", "of the bone that turns most"},
                [](const MuscleReplayRow& r) { return text(r.frame.angle_deg); }},
               {{"warm_up", "", "1: left out of medians"},
                [](const MuscleReplayRow& r) { return text(r.frame.warm_up ? 1 : 0); }},
               {{"iterations", "", "collision steps of the frame"},
                [](const MuscleReplayRow& r) { return text(r.frame.iterations); }},
               {{"muscle", "", "its name"}, [](const MuscleReplayRow& r) { return r.answers.muscle; }},
               {{"contacts", "", "with bones, answered; sum over the steps"},
                [](const MuscleReplayRow& r) { return text(r.answers.contacts); }},
           }),
           columns_of_accuracy<MuscleReplayRow>);

constexpr auto columns_of_pairs = joined(
    std::to_array<Column<PairReplayRow>>({
        {{"frame", "", "of the recording, 1 for the first"},
         [](const PairReplayRow& r) { return text(r.frame.frame); }},
        {{"angle_deg", "deg", "of the bone that turns most"},
         [](const PairReplayRow& r) { return text(r.frame.angle_deg); }},
        {{"warm_up", "", "1: left out of medians"},
         [](const PairReplayRow& r) { return text(r.frame.warm_up ? 1 : 0); }},
        {{"iterations", "", "collision steps of the frame"},
         [](const PairReplayRow& r) { return text(r.frame.iterations); }},
        {{"muscle", "", "its name"}, [](const PairReplayRow& r) { return r.pair.muscle; }},
        {{"other", "", "the bone, or the muscle that it touches"}, [](const PairReplayRow& r) { return r.pair.other; }},
        {{"backend", "", "that detects it"}, [](const PairReplayRow& r) { return r.pair.backend; }},
        {{"detect_ns", "ns", "asking the nodes of the pair; sum over the steps and over threads; empty: not told"},
         [](const PairReplayRow& r) { return text(r.pair.detect_ns); }},
        {{"backend_ns", "ns",
          "detection by that backend of all of its pairs of muscles, with following their surfaces; sum over the "
          "steps; "
          "empty with bones: see frames.csv"},
         [](const PairReplayRow& r) { return text(r.pair.backend_ns); }},
        {{"contacts", "", "nodes in the bone, or of either muscle in the other, answered; sum over the steps"},
         [](const PairReplayRow& r) { return text(r.pair.contacts); }},
    }),
    columns_of_accuracy<PairReplayRow>,
    std::to_array<Column<PairReplayRow>>({
        {{"involuntary_switches", "", "times that the scheduler gave the CPU to others while the frame was timed"},
         [](const PairReplayRow& r) { return text(r.frame.involuntary_switches); }},
    }));

std::vector<MuscleReplayRow> muscle_rows(const ReplayResult& result) {
  std::vector<MuscleReplayRow> rows;
  for (const ReplayRecord& frame : result.records) {
    for (const MuscleAnswers& answers : frame.muscles) rows.push_back({frame, answers});
  }
  return rows;
}

/// Frame after frame, with bones and then between muscles.
std::vector<PairReplayRow> pair_rows(const ReplayResult& result) {
  std::vector<PairReplayRow> rows;
  for (std::size_t i = 0; i < result.records.size(); ++i) {
    for (const PairReplay& pair : result.records[i].pairs) rows.push_back({result.records[i], pair});
    if (!result.muscles) continue;
    const MuscleReplayRecord& between = result.muscles->records[i];
    for (const PairReplay& pair : between.pairs) rows.push_back({between, pair});
  }
  return rows;
}

}  // namespace

std::span<const Column<ReplayRecord>> replay_columns() { return columns_of_replay; }

std::span<const Column<MuscleReplayRow>> replay_muscle_columns() { return columns_of_muscles; }

std::span<const Column<PairReplayRow>> replay_pair_columns() { return columns_of_pairs; }

std::string replay_id(const ReplayCase& replay) { return id_of(json_of_replay(replay), replay.scene); }

void write_replay(const fs::path& folder, const ReplayCase& replay, const ReplayResult& result,
                  const RecordingHeader& header, const fs::path& recording) {
  write_result_folder(folder, [&](const fs::path& part) {
    write_table_file(part / "frames.csv", replay_columns(), std::span<const ReplayRecord>(result.records));
    if (replay.scene.muscles.size() > 1) {
      write_table_file(part / "muscles.csv", replay_muscle_columns(),
                       std::span<const MuscleReplayRow>(muscle_rows(result)));
      write_table_file(part / "pairs.csv", replay_pair_columns(), std::span<const PairReplayRow>(pair_rows(result)));
    }
    OutputFile json(part / "run.json");
    json.stream() << text_of(manifest(replay, result, header, recording), 2) << '\n';
    json.close();
  });
}

}  // namespace musclebench
