#include "core/measure/fibre_record.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include <fmt/format.h>

#include "core/base/percentile.hpp"
#include "core/measure/number_cell.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

namespace {

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Nothing of nothing.
std::string of_all(const std::vector<double>& ascending, double (*figure)(const std::vector<double>&)) {
  return ascending.empty() ? std::string() : number_cell(figure(ascending));
}

double percentile_of(const std::vector<double>& ascending, double share) {
  return ascending[percentile_index(ascending.size(), share)];
}

constexpr std::array<Column<FibreRow>, 15> muscle_table{{
    {{"frame", "", "0: at rest"}, [](const FibreRow& r) { return fmt::format("{}", r.frame); }},
    {{"angle_deg", "deg", "of the bone that turns"},
     [](const FibreRow& r) { return number_cell(r.angle_rad * degrees_per_radian); }},
    {{"muscle", "", "its name"}, [](const FibreRow& r) { return r.muscle; }},
    {{"fibres", "", "that are followed"}, [](const FibreRow& r) { return fmt::format("{}", r.lengths_m.size()); }},
    {{"min_length_m", "m", "of the shortest fibre"},
     [](const FibreRow& r) { return of_all(r.lengths_m, [](const auto& all) { return all.front(); }); }},
    {{"mean_length_m", "m", "mean over the fibres"}, [](const FibreRow& r) { return of_all(r.lengths_m, mean); }},
    {{"max_length_m", "m", "of the longest fibre"},
     [](const FibreRow& r) { return of_all(r.lengths_m, [](const auto& all) { return all.back(); }); }},
    {{"min_moment_arm_m", "m", "least change of a fibre's length with the angle, > 0: longer as the angle grows"},
     [](const FibreRow& r) { return of_all(r.arms_m, [](const auto& all) { return all.front(); }); }},
    {{"p10_moment_arm_m", "m", "10th percentile over the fibres"},
     [](const FibreRow& r) { return of_all(r.arms_m, [](const auto& all) { return percentile_of(all, 0.1); }); }},
    {{"mean_moment_arm_m", "m", "mean over the fibres"},
     [](const FibreRow& r) { return r.of_mean ? number_cell(r.of_mean->arm_m) : std::string(); }},
    {{"p90_moment_arm_m", "m", "90th percentile over the fibres"},
     [](const FibreRow& r) { return of_all(r.arms_m, [](const auto& all) { return percentile_of(all, 0.9); }); }},
    {{"max_moment_arm_m", "m", "largest over the fibres"},
     [](const FibreRow& r) { return of_all(r.arms_m, [](const auto& all) { return all.back(); }); }},
    {{"moment_arm_error_m", "m", "of the mean: scatter of the lengths and distance of the frames"},
     [](const FibreRow& r) { return r.of_mean ? number_cell(r.of_mean->error_m) : std::string(); }},
    {{"inside_share", "", "of the fibres' points that are truly inside a bone"},
     [](const FibreRow& r) { return r.inside_share ? number_cell(*r.inside_share) : std::string(); }},
    {{"max_stretch", "", "largest length of a fibre over that at rest"},
     [](const FibreRow& r) { return number_cell(r.max_stretch); }},
}};

constexpr std::array<Column<FibreLengthRow>, 7> fibre_table{{
    {{"frame", "", "0: at rest"}, [](const FibreLengthRow& r) { return fmt::format("{}", r.frame); }},
    {{"angle_deg", "deg", "of the bone that turns"},
     [](const FibreLengthRow& r) { return number_cell(r.angle_rad * degrees_per_radian); }},
    {{"muscle", "", "its name"}, [](const FibreLengthRow& r) { return r.muscle; }},
    {{"fibre", "", "1 for the first"}, [](const FibreLengthRow& r) { return fmt::format("{}", r.fibre); }},
    {{"length_m", "m", "from the origin to the insertion"},
     [](const FibreLengthRow& r) { return number_cell(r.length_m); }},
    {{"moment_arm_m", "m", "change of the length with the angle, > 0: longer as the angle grows"},
     [](const FibreLengthRow& r) { return r.arm ? number_cell(r.arm->arm_m) : std::string(); }},
    {{"moment_arm_error_m", "m", "by the scatter of the lengths and the distance of the frames"},
     [](const FibreLengthRow& r) { return r.arm ? number_cell(r.arm->error_m) : std::string(); }},
}};

/// By fibre, then by frame.
std::vector<std::vector<std::optional<MomentArm>>> arms_of_fibres(std::span<const FibreFrame> frames,
                                                                  std::size_t muscle,
                                                                  std::span<const double> angles_rad) {
  std::vector<std::vector<std::optional<MomentArm>>> arms;
  for (std::size_t fibre = 0; fibre < frames.front().muscles[muscle].lengths_m.size(); ++fibre) {
    std::vector<double> lengths;
    for (const FibreFrame& frame : frames) lengths.push_back(frame.muscles[muscle].lengths_m[fibre]);
    arms.push_back(moment_arms(angles_rad, lengths));
  }
  return arms;
}

double largest_stretch(const std::vector<double>& lengths_m, const std::vector<double>& at_rest_m) {
  double largest = 0;
  for (std::size_t i = 0; i < lengths_m.size(); ++i) {
    if (at_rest_m[i] > 0) largest = std::max(largest, lengths_m[i] / at_rest_m[i]);
  }
  return largest;
}

}  // namespace

std::span<const Column<FibreRow>> fibre_columns() { return muscle_table; }
std::span<const Column<FibreLengthRow>> fibre_length_columns() { return fibre_table; }

FibreTables fibre_tables(std::span<const std::string> names, std::span<const FibreFrame> frames) {
  FibreTables tables;
  if (frames.empty()) return tables;
  std::vector<double> angles_rad;
  for (const FibreFrame& frame : frames) angles_rad.push_back(frame.angle_rad);
  std::vector<std::vector<std::vector<std::optional<MomentArm>>>> arms;
  std::vector<std::vector<std::optional<MomentArm>>> of_means;
  for (std::size_t muscle = 0; muscle < names.size(); ++muscle) {
    arms.push_back(arms_of_fibres(frames, muscle, angles_rad));
    std::vector<double> means;
    for (const FibreFrame& frame : frames) means.push_back(mean(frame.muscles[muscle].lengths_m));
    of_means.push_back(moment_arms(angles_rad, means));
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FibreFrame& frame = frames[i];
    for (std::size_t muscle = 0; muscle < names.size(); ++muscle) {
      const FibreRecord& record = frame.muscles[muscle];
      FibreRow row{frame.frame, frame.angle_rad,     names[muscle],      record.lengths_m,
                   {},          of_means[muscle][i], record.inside_share};
      row.max_stretch = largest_stretch(record.lengths_m, frames.front().muscles[muscle].lengths_m);
      for (std::size_t fibre = 0; fibre < record.lengths_m.size(); ++fibre) {
        const std::optional<MomentArm>& arm = arms[muscle][fibre][i];
        if (arm) row.arms_m.push_back(arm->arm_m);
        tables.fibres.push_back(
            {frame.frame, frame.angle_rad, names[muscle], static_cast<int>(fibre) + 1, record.lengths_m[fibre], arm});
      }
      std::ranges::sort(row.lengths_m);
      std::ranges::sort(row.arms_m);
      tables.muscles.push_back(std::move(row));
    }
  }
  return tables;
}

std::vector<std::string> slack_notes(std::span<const std::string> names, std::span<const FibreFrame> frames) {
  constexpr double noise = 1e-3;  // of a length: less is what contact and rounding leave
  std::vector<std::string> notes;
  for (std::size_t muscle = 0; muscle < names.size() && frames.size() > 1; ++muscle) {
    if (frames.front().muscles[muscle].lengths_m.empty()) continue;
    const double rest_m = mean(frames.front().muscles[muscle].lengths_m);
    const auto is_slack = [&](const FibreFrame& frame) {
      return mean(frame.muscles[muscle].lengths_m) < rest_m * (1 - noise);
    };
    const auto moved = frames.subspan(1);
    const auto slack = std::ranges::count_if(moved, is_slack);
    if (slack == 0) continue;
    notes.push_back(
        fmt::format("the fibres of {} are shorter than at rest in {} of {} frames, and nothing pulls on "
                    "them: where they are slack, the slope of their length is no moment arm of a taut "
                    "muscle (add fibre_force with a low level)",
                    names[muscle], slack, moved.size()));
  }
  return notes;
}

}  // namespace musclebench
