#include "bench/results/probe_output.hpp"

#include <array>

#include <fmt/format.h>

#include "bench/results/manifest.hpp"
#include "bench/results/result_folder.hpp"
#include "core/base/output_file.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

Json json_of_probe(const ProbeCase& what) {
  Json json = json_of_case(what, "probe");
  json["points"] = what.points;
  json["seed"] = what.seed;
  json["band_m"] = what.band_m;
  return json;
}

Json json_of_probed_bones(const ProbeResult& result) {
  Json bones = Json::array();
  for (const ProbedBone& bone : result.bones) {
    Json json = {{"name", bone.name}, {"cell_edge_m", nullptr}};
    if (bone.cell_edge_m > 0) {
      json["cell_edge_m"] = bone.cell_edge_m;
    }
    json["sharp_radius_m"] = bone.sharp_radius_m;
    json["sharp_edges"] = bone.sharp_edges;
    json["sharp_vertices"] = bone.sharp_vertices;
    bones.push_back(json);
  }
  return bones;
}

Json manifest(const ProbeCase& what, const ProbeResult& result) {
  Json json = manifest_head(result.status, result.status_detail, json_of_probe(what), what);
  const bool built = result.status == "ok";
  json["structure_bytes"] = built ? Json(result.structure_bytes) : Json(nullptr);
  add_origin(json, result.structures);
  if (!built) json["structures"] = nullptr;
  json["build_ns"] = built ? Json(result.build_ns) : Json(nullptr);
  json["detect_ns"] = built ? Json(result.detect_ns) : Json(nullptr);
  json["probed"] = json_of_probed_bones(result);
  return json;
}

/// Empty where nothing was measured.
template <double ErrorStatistics::*member>
std::string error(const ProbeRow& row) {
  return row.measured_points > 0 ? fmt::format("{}", row.errors_m.*member) : "";
}

constexpr auto columns_of_probe = std::to_array<Column<ProbeRow>>({
    {{"bone", "", "that was asked about"}, [](const ProbeRow& r) { return r.bone; }},
    {{"region", "", "smooth, sharp (within a mean edge of one that turns by more than 30 degrees) or all"},
     [](const ProbeRow& r) { return r.region; }},
    {{"points", "", "asked"}, [](const ProbeRow& r) { return fmt::format("{}", r.points); }},
    {{"measured_points", "", "of them inside, or reported so: what the errors are over"},
     [](const ProbeRow& r) { return fmt::format("{}", r.measured_points); }},
    {{"max_error_m", "m", "largest error of the depth"}, error<&ErrorStatistics::max>},
    {{"p99_error_m", "m", "99th percentile of it"}, error<&ErrorStatistics::p99>},
    {{"mean_error_m", "m", "mean of it"}, error<&ErrorStatistics::mean>},
    {{"rms_error_m", "m", "root of the mean square of it"}, error<&ErrorStatistics::rms>},
    {{"wrong_side", "", "share of the points that were told on the wrong side"},
     [](const ProbeRow& r) {
       return r.points > 0 ? fmt::format("{}", static_cast<double>(r.wrong_side) / r.points) : "";
     }},
});

void write_files(const fs::path& folder, const ProbeCase& what, const ProbeResult& result) {
  OutputFile rows(folder / "probe.csv");
  write_table(rows.stream(), probe_columns(), std::span<const ProbeRow>(result.rows));
  rows.close();
  OutputFile json(folder / "run.json");
  json.stream() << text_of(manifest(what, result), 2) << '\n';
  json.close();
}

}  // namespace

std::span<const Column<ProbeRow>> probe_columns() { return columns_of_probe; }

std::string probe_id(const ProbeCase& what) { return id_of(json_of_probe(what), what.scene); }

void write_probe(const fs::path& folder, const ProbeCase& what, const ProbeResult& result) {
  write_result_folder(folder, [&](const fs::path& part) { write_files(part, what, result); });
}

}  // namespace musclebench
