#include "core/recording/recording_header.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

using Json = nlohmann::ordered_json;

constexpr int rounding_bits = 32;

ParameterValue parameter_of(const Json& json) {
  if (json.is_boolean()) {
    return json.get<bool>();
  }
  if (json.is_number_integer()) {
    return json.get<std::int64_t>();
  }
  if (json.is_number()) {
    return json.get<double>();
  }
  return json.get<std::string>();
}

using Values = std::map<std::string, ParameterValue>;

Values values_of(const Json& json) {
  Values values;
  for (const auto& [key, value] : json.items()) values[key] = parameter_of(value);
  return values;
}

/// Where a file may lack them.
Values values_of(const Json& json, const char* key) { return json.contains(key) ? values_of(json.at(key)) : Values{}; }

Json json_of(const Values& values) {
  Json json = Json::object();
  for (const auto& [name, value] : values) {
    std::visit([&, &key = name](const auto& held) { json[key] = held; }, value);
  }
  return json;
}

/// A count as the file has it; what is no whole number of that type's range is refused, not bent.
int count_of(const Json& value) {
  if (!value.is_number_integer() || value.get<std::int64_t>() < 0 ||
      value.get<std::int64_t>() > std::numeric_limits<int>::max()) {
    throw Json::type_error::create(302, "not a count", &value);
  }
  return value.get<int>();
}

RecordingHeader header_of(const Json& json) {
  RecordingHeader header;
  header.scene = json.at("scene");
  header.scene_source = json.at("scene_source");
  header.preset = json.at("preset");
  header.loop_overrides = values_of(json.at("loop_overrides"));
  header.motion_overrides = values_of(json, "motion_overrides");
  header.mesh_overrides = values_of(json, "mesh_overrides");
  header.scene_sha256 = json.at("scene_sha256");
  header.backend = json.at("backend");
  header.build = json.at("build");
  header.nodes = count_of(json.at("nodes"));
  header.muscles = json.contains("muscles") ? count_of(json.at("muscles")) : 1;  // once there was only one
  header.muscle_contact = json.contains("muscle_contact") && json.at("muscle_contact").get<bool>();
  header.bones = count_of(json.at("bones"));
  header.substeps = count_of(json.at("substeps"));
  header.iterations = count_of(json.at("iterations"));
  header.rounding_m = json.at("rounding_m");
  header.angles_deg = json.at("angles_deg").get<std::vector<double>>();
  for (const Json& node : json.at("free_nodes")) {
    header.free_nodes.push_back(count_of(node));
  }
  return header;
}

bool is_consistent(const RecordingHeader& header) {
  const std::vector<int>& free_nodes = header.free_nodes;
  const bool ascending =
      std::adjacent_find(free_nodes.begin(), free_nodes.end(), std::greater_equal<>()) == free_nodes.end();
  const bool in_range = free_nodes.empty() || (free_nodes.front() >= 0 && free_nodes.back() < header.nodes);
  return header.nodes > 0 && header.muscles > 0 && header.bones > 0 && header.substeps > 0 && header.iterations > 0 &&
         std::int64_t{header.substeps} * header.iterations < std::int64_t{1} << 31 && header.frames() > 0 &&
         std::isfinite(header.rounding_m) && header.rounding_m > 0 && ascending && in_range;
}

}  // namespace

double rounding_step_m(double scene_diagonal_m) {
  int exponent = 0;
  std::frexp(scene_diagonal_m, &exponent);
  return std::ldexp(1.0, exponent - 1 - rounding_bits);
}

std::string text_of(const RecordingHeader& header) {
  Json json = {{"scene", header.scene},
               {"scene_source", header.scene_source},
               {"preset", header.preset},
               {"loop_overrides", json_of(header.loop_overrides)},
               {"scene_sha256", header.scene_sha256},
               {"backend", header.backend},
               {"build", header.build},
               {"nodes", header.nodes},
               {"muscles", header.muscles},
               {"bones", header.bones},
               {"frames", header.frames()},
               {"substeps", header.substeps},
               {"iterations", header.iterations},
               {"rounding_m", header.rounding_m},
               {"angles_deg", header.angles_deg},
               {"free_nodes", header.free_nodes}};
  if (header.muscle_contact) json["muscle_contact"] = true;
  if (!header.motion_overrides.empty()) json["motion_overrides"] = json_of(header.motion_overrides);
  if (!header.mesh_overrides.empty()) json["mesh_overrides"] = json_of(header.mesh_overrides);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

RecordingHeader header_of(std::string_view text, std::string_view location) {
  try {
    RecordingHeader header = header_of(Json::parse(text));
    if (is_consistent(header)) {
      return header;
    }
  } catch (const Json::exception& failure) {
    throw InputError(location, fmt::format("has a header that cannot be read ({}); record it again", failure.what()));
  }
  throw InputError(location, "has a header that contradicts itself; record it again");
}

}  // namespace musclebench
