#include "bench/results/probe_output.hpp"

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
  Json json = manifest_head(result.status, result.status_detail, json_of_probe(what), what.scene);
  const bool built = result.status == "ok";
  json["structure_bytes"] = built ? Json(result.structure_bytes) : Json(nullptr);
  json["structures"] = built ? Json(result.structures_loaded ? "loaded" : "built") : Json(nullptr);
  json["build_ns"] = built ? Json(result.build_ns) : Json(nullptr);
  json["detect_ns"] = built ? Json(result.detect_ns) : Json(nullptr);
  json["probed"] = json_of_probed_bones(result);
  return json;
}

/// Empty where there is nothing to be said.
std::string cells_of(const ProbeRow& row) {
  std::string text = fmt::format("{},{},{},{}", row.bone, row.place, row.points, row.measured_points);
  for (const double error_m : {row.errors_m.max, row.errors_m.p99, row.errors_m.mean, row.errors_m.rms}) {
    text += row.measured_points > 0 ? fmt::format(",{}", error_m) : ",";
  }
  return text + (row.points > 0 ? fmt::format(",{}", static_cast<double>(row.wrong_side) / row.points) : ",");
}

void write_files(const fs::path& folder, const ProbeCase& what, const ProbeResult& result) {
  OutputFile rows(folder / "probe.csv");
  rows.stream() << "bone,place,points,measured_points,max_error_m,p99_error_m,mean_error_m,rms_error_m,wrong_side\n";
  for (const ProbeRow& row : result.rows) {
    rows.stream() << cells_of(row) << '\n';
  }
  rows.close();
  OutputFile json(folder / "run.json");
  json.stream() << text_of(manifest(what, result), 2) << '\n';
  json.close();
}

}  // namespace

std::string probe_id(const ProbeCase& what) { return id_of(json_of_probe(what), what.scene); }

void write_probe(const fs::path& folder, const ProbeCase& what, const ProbeResult& result) {
  write_result_folder(folder, [&](const fs::path& part) { write_files(part, what, result); });
}

}  // namespace musclebench
