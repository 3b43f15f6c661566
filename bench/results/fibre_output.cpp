#include "bench/results/fibre_output.hpp"

#include <algorithm>
#include <sstream>
#include <vector>

#include <fmt/format.h>

#include "core/base/output_file.hpp"
#include "core/base/table_file.hpp"
#include "core/measure/fibre_record.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> muscle_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const Body& body : scene.bodies()) names.push_back(body.name);
  return names;
}

/// Lines of all muscles, one after the other.
struct Lines {
  std::vector<Vec3> points;
  std::vector<std::size_t> sizes;   // by line
  std::vector<std::size_t> muscle;  // by line
  std::vector<double> stretch;      // by line
};

Lines lines_of(const Snapshot& snapshot, const RunResult& result) {
  Lines lines;
  const auto at = std::ranges::find(result.fibres, snapshot.frame, &FibreFrame::frame);
  for (std::size_t muscle = 0; muscle < snapshot.fibres.size(); ++muscle) {
    const std::vector<Vec3>& points = snapshot.fibres[muscle];
    const std::vector<double>& lengths_m = at->muscles[muscle].lengths_m;
    const std::vector<double>& rest_m = result.fibres.front().muscles[muscle].lengths_m;
    lines.points.insert(lines.points.end(), points.begin(), points.end());
    for (std::size_t fibre = 0; fibre < lengths_m.size(); ++fibre) {
      lines.sizes.push_back(points.size() / lengths_m.size());
      lines.muscle.push_back(muscle);
      lines.stretch.push_back(rest_m[fibre] > 0 ? lengths_m[fibre] / rest_m[fibre] : 1);
    }
  }
  return lines;
}

void write_lines(const fs::path& path, const Lines& lines) {
  std::ostringstream text;
  text << "# vtk DataFile Version 3.0\nfibres of muscles, m\nASCII\nDATASET POLYDATA\n";
  text << fmt::format("POINTS {} double\n", lines.points.size());
  for (const Vec3& point : lines.points) text << fmt::format("{} {} {}\n", point.x(), point.y(), point.z());
  text << fmt::format("LINES {} {}\n", lines.sizes.size(), lines.sizes.size() + lines.points.size());
  std::size_t point = 0;
  for (const std::size_t size : lines.sizes) {
    text << size;
    for (std::size_t i = 0; i < size; ++i) text << ' ' << point++;
    text << '\n';
  }
  text << fmt::format("CELL_DATA {}\nSCALARS muscle int 1\nLOOKUP_TABLE default\n", lines.sizes.size());
  for (const std::size_t muscle : lines.muscle) text << muscle << '\n';
  text << "SCALARS stretch double 1\nLOOKUP_TABLE default\n";
  for (const double stretch : lines.stretch) text << fmt::format("{}\n", stretch);
  OutputFile file(path);
  file.stream() << text.str();
  file.close();
}

}  // namespace

std::string fibre_file(const Snapshot& snapshot) { return fmt::format("snapshots/fibres_{:04}.vtk", snapshot.frame); }

void write_fibres(const fs::path& folder, const RunCase& run, const RunResult& result) {
  const FibreTables tables = fibre_tables(muscle_names(run.scene), result.fibres);
  write_table_file(folder / "fibres.csv", fibre_columns(), std::span<const FibreRow>(tables.muscles));
  write_table_file(folder / "fibre_lengths.csv", fibre_length_columns(),
                   std::span<const FibreLengthRow>(tables.fibres));
  for (const Snapshot& snapshot : result.snapshots)
    write_lines(folder / fibre_file(snapshot), lines_of(snapshot, result));
}

Json json_of_fibres(const RunResult& result) {
  Json fibres = Json::array();
  for (const FollowedFibres& muscle : result.followed_fibres) {
    fibres.push_back({{"muscle", muscle.muscle}, {"asked", muscle.asked}, {"followed", muscle.followed}});
  }
  return fibres;
}

std::string fibre_summary(const RunCase& run, const RunResult& result) {
  std::string text;
  const FibreTables tables = fibre_tables(muscle_names(run.scene), result.fibres);
  for (const FollowedFibres& muscle : result.followed_fibres) {
    std::vector<double> lengths_m;
    std::vector<double> arms_m;
    double error_m = 0;
    for (const FibreRow& row : tables.muscles) {
      if (row.muscle != muscle.muscle) continue;
      lengths_m.push_back(row.lengths_m.front());
      lengths_m.push_back(row.lengths_m.back());
      if (!row.of_mean) continue;
      arms_m.push_back(row.of_mean->arm_m);
      error_m = std::max(error_m, row.of_mean->error_m);
    }
    const auto [shortest, longest] = std::ranges::minmax(lengths_m);
    text += fmt::format("  {:>3} fibres of {:<16} {:>6.1f} to {:.1f} mm long", muscle.followed, muscle.muscle,
                        1e3 * shortest, 1e3 * longest);
    if (!arms_m.empty()) {
      const auto [least, largest] = std::ranges::minmax(arms_m);
      text += fmt::format(", mean moment arm {:.1f} to {:.1f} mm (off by {:.2f} mm at most)", 1e3 * least,
                          1e3 * largest, 1e3 * error_m);
    }
    text += "\n";
  }
  return text;
}

}  // namespace musclebench
