#include "bench/results/advice_json.hpp"

#include <optional>
#include <variant>

namespace musclebench {

namespace {

Json json_of(const Settings& settings) {
  Json json = Json::object();
  for (const auto& [name, value] : settings) {
    std::visit([&, &key = name](const auto& known) { json[key] = known; }, value);
  }
  return json;
}

Json json_of(const std::optional<Trial>& trial) {
  if (!trial) return nullptr;
  return {{"status", trial->status},
          {"status_detail", trial->status_detail},
          {"frames", trial->frames},
          {"node_depth_m", trial->node_depth_m},
          {"surface_depth_m", trial->surface_depth_m ? Json(*trial->surface_depth_m) : Json(nullptr)},
          {"tunnelled_nodes", trial->tunnelled_nodes},
          {"frame_ns", trial->frame_ns}};
}

/// `holds`: it was run and judged, and held. One that was only asked about, or run and not judged yet, promises.
Json json_of(const Assessment& row, double wanted_m, bool holds) {
  const MedianEstimate& time = row.collision_ns;
  Json json = {{"configuration", row.configuration.text()},
               {"backend", row.configuration.backend},
               {"parameters", json_of(row.configuration.parameters)},
               {"error_m", row.error_m},
               {"max_error_m", row.max_error_m},
               {"contacts", nullptr},
               {"collision_ns", {{"median", time.median}, {"low", time.low}, {"high", time.high}}},
               {"build_ns", row.build_ns},
               {"structure_bytes", row.structure_bytes},
               {"promises", row.error_m <= wanted_m},
               {"trial", json_of(row.trial)},
               {"refusal", row.refusal},
               {"holds", holds}};
  if (row.contacts) {
    json["contacts"] = {{"true", row.contacts->real}, {"missed", row.contacts->missed}, {"false", row.contacts->wrong}};
  }
  return json;
}

}  // namespace

Json json_of(const Advice& advice, double wanted_m) {
  const auto named = [&](const std::optional<std::size_t>& row) {
    return row ? Json(advice.measured[*row].configuration.text()) : Json(nullptr);
  };
  Json json = {{"chosen", named(advice.chosen)},
               {"untried", named(advice.untried)},
               {"best", named(advice.best)},
               {"unit_of_price", nullptr}};
  if (advice.unit_of_price) json["unit_of_price"] = advice.unit_of_price->text();
  json["measured"] = Json::array();
  for (std::size_t i = 0; i < advice.measured.size(); ++i) {
    json["measured"].push_back(json_of(advice.measured[i], wanted_m, advice.chosen == i));
  }
  json["omitted"] = Json::array();
  for (const Omission& omission : advice.omitted) {
    json["omitted"].push_back({{"configuration", omission.configuration.text()}, {"reason", omission.reason}});
  }
  return json;
}

}  // namespace musclebench
