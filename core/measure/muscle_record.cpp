#include "core/measure/muscle_record.hpp"

#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace musclebench {

namespace {

std::string finite(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string if_judged(const MuscleRow& row, double value) { return row.step.judged ? finite(value) : ""; }

std::string count_if(bool known, int value) { return known ? fmt::format("{}", value) : ""; }

constexpr std::array<Column<MuscleRow>, 13> table{{
    {{"frame", "", "1 for the first"}, [](const MuscleRow& r) { return fmt::format("{}", r.step.frame); }},
    {{"angle_deg", "deg", "of the bone that turns most"}, [](const MuscleRow& r) { return finite(r.step.angle_deg); }},
    {{"muscle", "", "its name"}, [](const MuscleRow& r) { return r.muscle; }},
    {{"contacts", "", "with bones, in the frame's last detection; with those in a margin"},
     [](const MuscleRow& r) { return fmt::format("{}", r.record.contacts); }},
    {{"nodes_inside", "", "free nodes truly inside a bone at the end of the frame"},
     [](const MuscleRow& r) { return count_if(r.step.judged, r.record.in_bones.nodes_inside); }},
    {{"max_depth_m", "m", "true depth of the deepest of them"},
     [](const MuscleRow& r) { return if_judged(r, r.record.in_bones.max_depth_m); }},
    {{"p99_depth_m", "m", "99th percentile of their depths"},
     [](const MuscleRow& r) { return if_judged(r, r.record.in_bones.p99_depth_m); }},
    {{"mean_depth_m", "m", "mean of their depths"},
     [](const MuscleRow& r) { return if_judged(r, r.record.in_bones.mean_depth_m); }},
    {{"nodes_inside_muscles", "", "nodes truly inside another muscle that this one touches"},
     [](const MuscleRow& r) { return count_if(r.step.in_muscles.has_value(), r.record.in_muscles.nodes_inside); }},
    {{"max_muscle_depth_m", "m", "true depth of the deepest of them"},
     [](const MuscleRow& r) { return r.step.in_muscles ? finite(r.record.in_muscles.max_depth_m) : std::string(); }},
    {{"volume_m3", "m3", "at the end of the frame"}, [](const MuscleRow& r) { return finite(r.record.volume_m3); }},
    {{"max_edge_stretch", "", "longest edge over its length at rest"},
     [](const MuscleRow& r) { return finite(r.record.edge_stretch.max); }},
    {{"p99_edge_stretch", "", "99th percentile of edge length over length at rest"},
     [](const MuscleRow& r) { return finite(r.record.edge_stretch.p99); }},
}};

}  // namespace

std::span<const Column<MuscleRow>> muscle_columns() { return table; }

void write_muscles_csv(std::ostream& out, std::span<const std::string> names, std::span<const StepRecord> records) {
  std::vector<MuscleRow> rows;
  for (const StepRecord& record : records) {
    for (std::size_t i = 0; i < record.muscles.size(); ++i) rows.push_back({record, names[i], record.muscles[i]});
  }
  write_table(out, std::span<const Column<MuscleRow>>(table), std::span<const MuscleRow>(rows));
}

}  // namespace musclebench
