#include "bench/results/force_output.hpp"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "core/base/table_file.hpp"

namespace musclebench {

namespace {

/// By the bone of the joint: least and largest torque over the frames, N m.
std::map<std::string, std::pair<double, double>> torques_of(const RunResult& result) {
  std::map<std::string, std::pair<double, double>> torques;
  for (const ForceRow& row : result.forces) {
    if (row.source != ForceSource::joint || !row.torque_n_m) continue;
    auto& [least, largest] = torques.try_emplace(row.other, *row.torque_n_m, *row.torque_n_m).first->second;
    least = std::min(least, *row.torque_n_m);
    largest = std::max(largest, *row.torque_n_m);
  }
  return torques;
}

/// The contact with the largest `figure`; null where there is none.
template <typename Figure>
const ForceRow* largest_contact(const RunResult& result, const Figure& figure) {
  const ForceRow* largest = nullptr;
  for (const ForceRow& row : result.forces) {
    if (figure(row).value_or(0) > (largest == nullptr ? 0 : *figure(*largest))) largest = &row;
  }
  return largest;
}

std::optional<double> pressure_pa(const ForceRow& row) { return row.peak_pressure_pa; }
std::optional<double> push_n(const ForceRow& row) { return row.normal_n; }

std::string place_of(const ForceRow& row) {
  const std::string other = row.other.empty() ? "what no contact tells" : row.other;
  return fmt::format("({} on {}, frame {})", row.muscle, other, row.frame);
}

}  // namespace

std::string bone_pressure_file(const Snapshot& snapshot) {
  return fmt::format("snapshots/bones_{:04}.csv", snapshot.frame);
}

void write_forces(const std::filesystem::path& folder, const RunResult& result) {
  write_table_file(folder / "forces.csv", force_columns(), std::span<const ForceRow>(result.forces));
  for (const Snapshot& snapshot : result.snapshots) {
    if (snapshot.contact.pressures_pa.empty()) continue;
    write_table_file(folder / bone_pressure_file(snapshot), bone_vertex_columns(), std::span(snapshot.on_bones));
  }
}

Json json_of_forces(const RunResult& result) {
  Json json = {{"rows", result.forces.size()},
               {"contacts_left_out", result.force_obstacles.contacts},
               {"attachments_left_out", result.force_obstacles.attachments},
               {"joints", Json::array()}};
  for (const auto& [bone, range] : torques_of(result)) {
    json["joints"].push_back({{"bone", bone}, {"min_torque_n_m", range.first}, {"max_torque_n_m", range.second}});
  }
  const ForceRow* pressed = largest_contact(result, pressure_pa);
  json["peak_pressure_pa"] = pressed != nullptr ? Json(*pressed->peak_pressure_pa) : Json(nullptr);
  return json;
}

std::string force_summary(const RunResult& result) {
  std::string text;
  for (const auto& [bone, range] : torques_of(result)) {
    text += fmt::format("  {:<29} {:>10.3g} to {:.3g} N m\n", fmt::format("torque of muscles on {}", bone), range.first,
                        range.second);
  }
  if (const ForceRow* pushed = largest_contact(result, push_n)) {
    text += fmt::format("  largest contact force         {:>10.3g} N {}\n", *pushed->normal_n, place_of(*pushed));
  }
  if (const ForceRow* pressed = largest_contact(result, pressure_pa)) {
    text += fmt::format("  peak contact pressure         {:>10.3g} Pa {}\n", *pressed->peak_pressure_pa,
                        place_of(*pressed));
  }
  return text;
}

}  // namespace musclebench
