#include "core/scene/read_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

constexpr double radians_per_degree = std::numbers::pi / 180;
constexpr double most_degrees = 3600;

/// A unit vector; the largest component is brought to 1 first where the square would be too large or small for a
/// double.
Vec3 read_axis(const TomlTable& table) {
  Vec3 axis = table.point("axis");
  const double largest = axis.cwiseAbs().maxCoeff();
  if (!(largest > 0)) {
    throw InputError(table.location("axis"), "has no length; give the direction of the rotation axis");
  }
  if (!std::isnormal(axis.squaredNorm())) {
    axis /= largest;
  }
  return axis.normalized();
}

std::vector<std::string> course_words() { return {"there_and_back", "there", "rest_first", "rest_to_rest"}; }

/// From rest through the angles at one speed, and back to rest where it `returns`. Nothing turns: stays as it is.
void go_from_rest(BoneRotation& motion, bool returns) {
  std::vector<double> stops_rad = {0};
  const auto go_to = [&](double angle_rad) {
    if (angle_rad != stops_rad.back()) stops_rad.push_back(angle_rad);
  };
  for (const double angle_rad : motion.angles_rad) go_to(angle_rad);
  if (returns) go_to(0);
  if (stops_rad.size() == 1) return;
  motion.angles_rad = stops_rad;
  motion.times = {0};
  for (std::size_t i = 1; i < stops_rad.size(); ++i) {
    motion.times.push_back(motion.times.back() + std::abs(stops_rad[i] - stops_rad[i - 1]));
  }
}

BoneRotation read_rotation(const SceneRequest& request, const TomlTable& table) {
  table.allow_only({"axis", "centre_m", "from_deg", "to_deg", "course", "table", "column", "relative_to_first_row"});
  BoneRotation motion;
  motion.axis = read_axis(table);
  motion.centre_m = table.point("centre_m");
  constexpr double farthest_m = 1e9;  // beyond it rounding moves the bones by more than a micrometre
  if (!(motion.centre_m.cwiseAbs().maxCoeff() <= farthest_m)) {
    throw InputError(table.location("centre_m"), "is so far away that nothing turns about it; give metres");
  }
  const Parameters changed(motion_parameters(), request.motion_overrides, "--motion");
  const std::string course =
      changed.given("course") ? changed.word("course") : table.word_or("course", "there_and_back");
  const std::vector<std::string> courses = course_words();
  if (std::ranges::find(courses, course) == courses.end()) {
    throw InputError(table.location("course"), fmt::format("'{}' is not one of {}", course, fmt::join(courses, ", ")));
  }
  motion.there_and_back = course == "there_and_back";
  const bool starts_at_rest = course == "rest_first" || course == "rest_to_rest";
  if (table.has("table")) {
    if (changed.given("from_deg") || changed.given("to_deg")) {
      throw InputError("--motion",
                       fmt::format("{} has a table of angles, which from_deg and to_deg cannot change; leave "
                                   "them out",
                                   table.location()));
    }
    if (starts_at_rest) {
      throw InputError(changed.given("course") ? "--motion" : table.location("course"),
                       fmt::format("{} goes to from_deg first, and {} has a table of angles; put rest into the table",
                                   course, table.location()));
    }
    if (table.has("from_deg") || table.has("to_deg")) {
      throw InputError(table.location("table"), "contradicts from_deg and to_deg; give either a table or two angles");
    }
    const auto path = resolve_reference(request, table.word("table"), table.location("table")).path;
    const MotionTable rows =
        read_at(table.location("table"), [&] { return read_motion_table(path, table.word("column")); });
    const double zero = table.flag_or("relative_to_first_row", true) ? rows.values.front() : 0;
    motion.times = rows.times;
    for (const double value : rows.values) {
      motion.angles_rad.push_back((value - zero) * radians_per_degree);
    }
  } else {
    const auto angle_rad = [&](const char* key) {
      const double degrees = changed.given(key) ? changed.number(key) : table.number(key, -most_degrees, most_degrees);
      return degrees * radians_per_degree;
    };
    motion.times = {0, 1};
    motion.angles_rad = {angle_rad("from_deg"), angle_rad("to_deg")};
    if (starts_at_rest) go_from_rest(motion, course == "rest_to_rest");
  }
  return motion;
}

}  // namespace

std::vector<ParameterSpec> motion_parameters() {
  const auto angle = [](const char* name, const char* help) {
    return parameter::number({.name = name,
                              .unit = "deg",
                              .default_value = 0,
                              .minimum = -most_degrees,
                              .maximum = most_degrees,
                              .help = help});
  };
  return {angle("from_deg", "where the bones begin to turn, or go to first"), angle("to_deg", "where they turn to"),
          parameter::choice(
              {.name = "course",
               .choices = course_words(),
               .help = "there: ends at to_deg; there_and_back: returns; rest_first: from rest to from_deg, then to "
                       "to_deg, at one speed; rest_to_rest: the same, and back to rest"})};
}

BoneMotion read_motion(const SceneRequest& request, const TomlTable& bone) {
  BoneMotion motion;
  if (!bone.has("motion")) return motion;
  const std::vector<TomlTable> tables = bone.table_or_tables("motion");
  if (tables.size() > 1 && !request.motion_overrides.empty()) {
    throw InputError("--motion",
                     fmt::format("{} has several rotations, and --motion cannot choose one of them; change them in "
                                 "the scene",
                                 bone.location()));
  }
  for (const TomlTable& table : tables) motion.rotations.push_back(read_rotation(request, table));
  return motion;
}

}  // namespace musclebench
