#include "core/scene/bone_motion.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/base/input_file.hpp"

namespace musclebench {

double BoneRotation::angle_rad(double progress) const {
  if (angles_rad.empty()) {
    return 0;
  }
  const double part = there_and_back ? 1 - std::abs(2 * progress - 1) : progress;
  const double time = times.front() + std::clamp(part, 0.0, 1.0) * (times.back() - times.front());
  const auto next = std::upper_bound(times.begin() + 1, times.end() - 1, time);
  const auto i = static_cast<std::size_t>(next - times.begin());
  const double weight = (time - times[i - 1]) / (times[i] - times[i - 1]);
  return (1 - weight) * angles_rad[i - 1] + weight * angles_rad[i];
}

RigidMotion BoneRotation::pose(double progress) const {
  return angles_rad.empty() ? RigidMotion{} : RigidMotion::about_axis(axis, centre_m, angle_rad(progress));
}

bool BoneRotation::turns() const {
  return std::ranges::any_of(angles_rad, [&](double angle) { return angle != angles_rad.front(); });
}

RigidMotion BoneMotion::pose(double progress) const {
  if (rotations.empty()) return {};
  RigidMotion pose = rotations.front().pose(progress);
  for (std::size_t i = 1; i < rotations.size(); ++i) pose = pose * rotations[i].pose(progress);
  return pose;
}

double BoneMotion::largest_angle_rad(double progress) const {
  double largest_rad = 0;
  for (const BoneRotation& rotation : rotations) {
    const double angle_rad = rotation.angle_rad(progress);
    if (std::abs(angle_rad) > std::abs(largest_rad)) largest_rad = angle_rad;
  }
  return largest_rad;
}

bool BoneMotion::turns() const { return std::ranges::any_of(rotations, &BoneRotation::turns); }

namespace {

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) {
    words.push_back(word);
  }
  return words;
}

double number_at(const std::string& word, const std::string& location) {
  std::size_t used = 0;
  double value = NAN;
  try {
    value = std::stod(word, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != word.size() || !std::isfinite(value)) {
    throw InputError(location, fmt::format("'{}' is not a finite number", word));
  }
  constexpr double most = 1e9;  // seconds, degrees or radians: differences stay finite
  if (std::abs(value) > most) {
    throw InputError(location, fmt::format("'{}' is beyond {:g} in size; is the file damaged?", word, most));
  }
  return value;
}

/// What a line of the header tells of `key`, as "nRows=3", "nRows = 3" or, of older files, "datarows 3"; none for other
/// lines.
std::optional<std::size_t> told_count(std::string line, const std::array<std::string_view, 2>& keys) {
  std::ranges::replace(line, '=', ' ');
  const std::vector<std::string> words = words_of(line);
  if (words.size() != 2 || std::ranges::find(keys, words[0]) == keys.end()) return std::nullopt;
  std::size_t count = 0;
  const auto [end, error] = std::from_chars(words[1].data(), words[1].data() + words[1].size(), count);
  const bool is_number = error == std::errc() && end == words[1].data() + words[1].size();
  return is_number ? std::optional(count) : std::nullopt;
}

/// A file that was cut between two rows looks whole.
void require_told(const std::filesystem::path& path, std::optional<std::size_t> told, std::size_t found,
                  std::string_view what) {
  if (!told || *told == found) return;
  throw InputError(path.string(),
                   fmt::format("its header tells {} {}, and the file has {}: the file was cut, or the header "
                               "is wrong; copy the file again, or correct the header",
                               *told, what, found));
}

constexpr std::array<std::string_view, 2> row_keys = {"nRows", "datarows"};
constexpr std::array<std::string_view, 2> column_keys = {"nColumns", "datacolumns"};

}  // namespace

MotionTable read_motion_table(const std::filesystem::path& path, const std::string& column) {
  constexpr std::uintmax_t most_bytes = 256 << 20;
  std::istringstream file(InputFile(path).text(most_bytes));
  MotionTable table;
  std::vector<std::string> header;
  std::size_t value_column = 0;
  int line_number = 0;
  bool in_rows = false;
  bool in_degrees = true;
  std::optional<std::size_t> told_rows;
  std::optional<std::size_t> told_columns;
  for (std::string line; std::getline(file, line);) {
    const std::string location = fmt::format("{}:{}", path.string(), ++line_number);
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) {
      continue;
    }
    if (!in_rows) {
      in_rows = words.front() == "endheader";
      if (const auto rows = told_count(line, row_keys)) told_rows = rows;
      if (const auto columns = told_count(line, column_keys)) told_columns = columns;
      in_degrees = in_degrees && words.front() != "inDegrees=no";
      continue;
    }
    if (header.empty()) {
      header = words;
      const auto found = std::find(header.begin(), header.end(), column);
      if (found == header.end() || header.front() != "time") {
        throw InputError(location, fmt::format("has no column '{}' next to 'time'; did you mean '{}'?", column,
                                               nearest_word(column, header)));
      }
      value_column = static_cast<std::size_t>(found - header.begin());
      continue;
    }
    if (words.size() != header.size()) {
      throw InputError(location, fmt::format("has {} values, and the header has {} columns; correct the row",
                                             words.size(), header.size()));
    }
    table.times.push_back(number_at(words.front(), location));
    table.values.push_back(number_at(words[value_column], location) * (in_degrees ? 1 : 180 / std::numbers::pi));
    if (table.times.size() > 1 && !(table.times.back() > table.times[table.times.size() - 2])) {
      throw InputError(location, "time does not ascend; sort the rows by time");
    }
  }
  if (table.times.size() < 2) {
    throw InputError(path.string(), "holds fewer than two rows after 'endheader'; is it an OpenSim motion file?");
  }
  require_told(path, told_columns, header.size(), "columns");
  require_told(path, told_rows, table.times.size(), "rows");
  return table;
}

}  // namespace musclebench
